#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "common/mesh_distance.hpp"
#include "common/mesh_samples.hpp"
#include "mapping3d/surface/planes.hpp"
#include "mapping3d/surface/simplify.hpp"

namespace marco::mapping3d {
namespace {

// The inside of a box of 4 x 3 x 2.5 m as lattices of 5 cm, with noise along the normal.
TriangleMesh room(double sigma_m, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma_m);
  const Eigen::Vector3d size(4, 3, 2.5);
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, 1}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const int nu = static_cast<int>(std::lround(size[u] / 0.05));
      const int nv = static_cast<int>(std::lround(size[v] / 0.05));
      const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
      for (int j = 0; j <= nv; ++j) {
        for (int i = 0; i <= nu; ++i) {
          Eigen::Vector3d p;
          p[axis] = side * size[axis] + noise(random);
          p[u] = 0.05 * i;
          p[v] = 0.05 * j;
          mesh.vertices_m.push_back(p.cast<float>());
          Eigen::Vector3f n = Eigen::Vector3f::Zero();
          n[axis] = side == 0 ? 1.0F : -1.0F;
          mesh.normals.push_back(n);
        }
      }
      for (int j = 0; j < nv; ++j) {
        for (int i = 0; i < nu; ++i) {
          const auto a = first + static_cast<uint32_t>(j * (nu + 1) + i);
          const auto b = a + 1, c = a + static_cast<uint32_t>(nu) + 2, d = c - 1;
          if (side == 0) {
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
          } else {
            mesh.triangles.push_back({a, c, b});
            mesh.triangles.push_back({a, d, c});
          }
        }
      }
    }
  }
  return mesh;
}

// The slow twin: the foot on the plane where it lies inside, else the nearest of three edges.
double distance_to_triangle(const Eigen::Vector3d& p,
                            const std::array<Eigen::Vector3d, 3>& corner) {
  const Eigen::Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
  bool inside = true;
  double nearest = 1e9;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d edge = corner[(i + 1) % 3] - corner[i], off = p - corner[i];
    inside = inside && normal.cross(edge).dot(off) >= 0.0;
    const double along = std::clamp(off.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (off - along * edge).norm());
  }
  return inside ? std::abs(normal.dot(p - corner[0])) : nearest;
}

TEST(MeshDistance, EqualsTheNearestOfAllTriangles) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-0.5F, 0.5F);
  const auto point = [&] { return Eigen::Vector3f(place(random), place(random), place(random)); };
  TriangleMesh mesh;
  for (uint32_t i = 0; i < 30; ++i) {
    const Eigen::Vector3f corner = point();
    mesh.vertices_m.insert(mesh.vertices_m.end(),
                           {corner, corner + 0.3F * point(), corner + 0.3F * point()});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const MeshDistance distance(mesh, 0.1F);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3f p = point();
    double nearest = 0.1;
    for (const auto& [a, b, c] : mesh.triangles) {
      nearest = std::min(
          nearest, distance_to_triangle(p.cast<double>(), {mesh.vertices_m[a].cast<double>(),
                                                           mesh.vertices_m[b].cast<double>(),
                                                           mesh.vertices_m[c].cast<double>()}));
    }
    // Floats at half a metre: 1e-7, and more where a sliver's plane is badly held.
    EXPECT_NEAR(static_cast<double>(distance(p)), nearest, 2e-5);
    EXPECT_EQ(distance.any_within(p), distance(p) < 0.1F);
  }
}

// Its distance is not a number, and must not hide that of another triangle.
TEST(MeshDistance, PassesOverATriangleWithoutArea) {
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, -1, 0.05F}, {1, -1, 0.05F}, {0.5F, 1, 0.05F}};
  mesh.triangles = {{2, 3, 4}, {0, 0, 1}};
  EXPECT_NEAR(MeshDistance(mesh, 0.1F)({0.5F, 0, 0.06F}), 0.01F, 1e-6F);
}

// Of 5 m x 5 mm, seen from beside its middle, from above it and from its end: by hand.
TEST(MeshDistance, OfASliverIsExact) {
  TriangleMesh mesh;
  mesh.vertices_m = {{10, 20, 1}, {15, 20.001F, 1}, {12.5F, 20.005F, 1}};
  mesh.triangles = {{0, 1, 2}};
  const MeshDistance distance(mesh, 0.5F);
  EXPECT_NEAR(distance({12.5F, 20.205F, 1}), 0.2F, 1e-5F);
  EXPECT_NEAR(distance({12.5F, 20.003F, 1.001F}), 0.001F, 1e-5F);
  EXPECT_NEAR(distance({9.9F, 20, 1}), 0.1F, 1e-5F);
}

TEST(Simplify, FlatWallsBecomeFewTrianglesWithinTheBound) {
  // The noise's largest of 24 000 is four sigma.
  const TriangleMesh mesh = room(0.002, 5);
  const Simplified fewer = simplify(mesh, find_planes(mesh));
  EXPECT_LT(fewer.mesh.triangles.size(), mesh.triangles.size() / 20);
  EXPECT_EQ(fewer.mesh.normals.size(), fewer.mesh.vertices_m.size());
  // Checked again, finer, both ways.
  EXPECT_LE(gap(mesh, MeshDistance(fewer.mesh, 0.05F), 2e-4F).max_m, 0.01);
  EXPECT_LE(gap(fewer.mesh, MeshDistance(mesh, 0.05F), 2e-4F).max_m, 0.01);
}

TEST(Simplify, KeepsTheBoundAlsoOfScrapsAndOfRoughMeshes) {
  TriangleMesh mesh = room(0.0, 6);
  SimplifyOptions options;
  options.max_error_m = 0.003;
  options.sample_m2 = 1e-3;
  const Simplified flat = simplify(mesh, find_planes(mesh), options);
  EXPECT_LE(std::max(flat.there_m, flat.back_m), 0.003);
  // Six rectangles are twelve triangles.
  EXPECT_LT(flat.mesh.triangles.size(), 40U);
  // Scraps of 3 cm that hang 5 cm before a wall: a bound of the mean error swallows them.
  for (int i = 0; i < 40; ++i) {
    const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
    const Eigen::Vector3f at(0.05F, 0.5F + 0.05F * static_cast<float>(i), 1.0F);
    mesh.vertices_m.insert(mesh.vertices_m.end(), {at, at + Eigen::Vector3f(0, 0.03F, 0),
                                                   at + Eigen::Vector3f(0, 0, 0.03F)});
    mesh.normals.insert(mesh.normals.end(), 3, Eigen::Vector3f::UnitX());
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  TriangleMesh rough = room(0.01, 7);
  rough.triangles.resize(1500);
  for (const TriangleMesh& each : {mesh, rough}) {
    const Simplified fewer = simplify(each, {}, options);
    EXPECT_LT(fewer.mesh.triangles.size(), each.triangles.size());
    const auto area_m2 = static_cast<float>(options.sample_m2);
    EXPECT_LE(gap(each, MeshDistance(fewer.mesh, 0.05F), area_m2).max_m, options.max_error_m);
    EXPECT_LE(gap(fewer.mesh, MeshDistance(each, 0.05F), area_m2).max_m, options.max_error_m);
  }
}

// Two planes one after the other: each lies within reach of where the vertex is then, but both
// together would move it farther than the share of the bound that snapping has.
TEST(Simplify, SnappingMovesNoVertexFartherThanItsShare) {
  TriangleMesh mesh;
  for (uint32_t j = 0; j <= 20; ++j) {
    for (uint32_t i = 0; i <= 20; ++i) {
      mesh.vertices_m.emplace_back(0.05F * static_cast<float>(i), 0.05F * static_cast<float>(j), 0);
      mesh.normals.emplace_back(0, 0, 1);
      const uint32_t at = 21 * j + i;
      if (i == 20 || j == 20) continue;
      mesh.triangles.push_back({at, at + 1, at + 22});
      mesh.triangles.push_back({at, at + 22, at + 21});
    }
  }
  std::vector<SurfacePlane> planes(2);
  for (std::size_t i = 0; i < 2; ++i) {
    planes[i].low_m = {-2, -2};
    planes[i].high_m = {2, 2};
    planes[i].offset_m = i == 0 ? 0.004 : 0.008;
  }
  const Simplified fewer = simplify(mesh, planes);
  ASSERT_FALSE(fewer.mesh.vertices_m.empty());
  for (const Eigen::Vector3f& vertex : fewer.mesh.vertices_m) EXPECT_NEAR(vertex.z(), 0.004F, 1e-6);
}

TEST(Planes, OfARoomAreItsSixWithHonestUncertainty) {
  int inside = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const std::vector<SurfacePlane> planes = find_planes(room(0.004, seed));
    ASSERT_EQ(planes.size(), 6U);
    int floors = 0, ceilings = 0, walls = 0;
    const Eigen::Vector3d size(4, 3, 2.5);
    for (const SurfacePlane& plane : planes) {
      floors += plane.kind == SurfacePlane::Kind::floor;
      ceilings += plane.kind == SurfacePlane::Kind::ceiling;
      walls += plane.kind == SurfacePlane::Kind::wall;
      int axis = 0;
      plane.normal.cwiseAbs().maxCoeff(&axis);
      const double truth = plane.normal[axis] > 0 ? 0.0 : size[axis];
      const double error = plane.centre_m[axis] - truth;
      EXPECT_NEAR(error, 0.0, 0.001);
      inside += error * error < 4.0 * plane.covariance(0, 0);
      EXPECT_NEAR(plane.area_m2, size.prod() / size[axis], 0.3);
      EXPECT_LT(std::acos(std::abs(plane.normal[axis])), 0.001);
    }
    EXPECT_EQ(floors, 1);
    EXPECT_EQ(ceilings, 1);
    EXPECT_EQ(walls, 4);
  }
  // Within two sigma: 95 % of 24 are 23; fewer than 19 would be too sure, and below it must not be
  // too humble: 4 mm over a thousand patches.
  EXPECT_GE(inside, 19);
  const SurfacePlane plane = find_planes(room(0.004, 1)).front();
  EXPECT_LT(std::sqrt(plane.covariance(0, 0)), 0.0005);
}

TEST(Planes, AWallWithAGapIsOnePlaneAndATableTopIsLevel) {
  TriangleMesh mesh;
  const auto add = [&](const Eigen::Vector3f& at, const Eigen::Vector3f& u,
                       const Eigen::Vector3f& v) {
    const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
    mesh.vertices_m.insert(mesh.vertices_m.end(), {at, at + u, at + u + v, at + v});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  };
  add({0, 0, 0}, {6, 0, 0}, {0, 4, 0});        // floor
  add({0, 2, 0}, {0, 0, 2.5F}, {2, 0, 0});     // wall, left of a door
  add({3, 2, 0}, {0, 0, 2.5F}, {3, 0, 0});     // and right of it
  add({1, 0.5F, 0.7F}, {2, 0, 0}, {0, 1, 0});  // table
  const std::vector<SurfacePlane> planes = find_planes(mesh);
  ASSERT_EQ(planes.size(), 3U);
  EXPECT_EQ(planes[0].kind, SurfacePlane::Kind::floor);
  EXPECT_EQ(planes[1].kind, SurfacePlane::Kind::wall);
  EXPECT_NEAR(planes[1].area_m2, 12.5, 0.01);
  EXPECT_EQ(planes[2].kind, SurfacePlane::Kind::level);
  EXPECT_NEAR(planes[2].offset_m, 0.7, 1e-6);
}

TEST(Simplify, OfNothingIsNothing) {
  EXPECT_TRUE(simplify(TriangleMesh{}, find_planes(TriangleMesh{})).mesh.triangles.empty());
  // A triangle without an extent is no surface, and no reason to fail.
  TriangleMesh point;
  point.vertices_m.assign(3, Eigen::Vector3f::Zero());
  point.triangles = {{0, 1, 2}};
  EXPECT_TRUE(find_planes(point).empty());
  EXPECT_TRUE(simplify(point, {}).mesh.triangles.empty());
}

}  // namespace
}  // namespace marco::mapping3d
