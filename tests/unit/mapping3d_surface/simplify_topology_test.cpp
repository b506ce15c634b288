// Simplified surfaces are as whole as what they are made of: no crack, no second skin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <set>

#include "common/mesh_distance.hpp"
#include "mapping3d/surface/planes.hpp"
#include "mapping3d/surface/simplify.hpp"
#include "mapping3d/surface/welded.hpp"
#include "tests/support/mesh_wholeness.hpp"
#include "tests/support/second_sheets.hpp"

namespace marco::mapping3d {
namespace {

constexpr float kLatticeM = 0.05F;

using Surface = std::function<Eigen::Vector3f(float u_m, float v_m)>;
using Keep = std::function<bool(float u_m, float v_m)>;

// A lattice over u x v, counter-clockwise seen from u x v; normals are added afterwards.
void add_lattice(
    TriangleMesh& mesh,
    const Eigen::Vector2f& size_m,
    const Surface& surface,
    const Keep& keep = [](float, float) { return true; }) {
  const auto nu = static_cast<uint32_t>(std::lround(size_m.x() / kLatticeM));
  const auto nv = static_cast<uint32_t>(std::lround(size_m.y() / kLatticeM));
  const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
  const auto along = [](uint32_t i) { return kLatticeM * static_cast<float>(i); };
  for (uint32_t j = 0; j <= nv; ++j) {
    for (uint32_t i = 0; i <= nu; ++i) mesh.vertices_m.push_back(surface(along(i), along(j)));
  }
  for (uint32_t j = 0; j < nv; ++j) {
    for (uint32_t i = 0; i < nu; ++i) {
      if (!keep(along(i) + 0.5F * kLatticeM, along(j) + 0.5F * kLatticeM)) continue;
      const uint32_t a = first + j * (nu + 1) + i, d = a + nu + 1;
      mesh.triangles.push_back({a, a + 1, d + 1});
      mesh.triangles.push_back({a, d + 1, d});
    }
  }
}

// Welds, moves every vertex by noise and gives it its normal.
TriangleMesh measured(TriangleMesh mesh, float sigma_m, unsigned seed) {
  if (auto one = welded(mesh)) mesh = *std::move(one);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0F, sigma_m);
  for (Eigen::Vector3f& at : mesh.vertices_m) {
    at += Eigen::Vector3f(noise(random), noise(random), noise(random));
  }
  mesh.normals.assign(mesh.vertices_m.size(), Eigen::Vector3f::Zero());
  const auto& at = mesh.vertices_m;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f normal = (at[b] - at[a]).cross(at[c] - at[a]);
    for (const uint32_t corner : {a, b, c}) mesh.normals[corner] += normal;
  }
  for (Eigen::Vector3f& normal : mesh.normals) normal.normalize();
  return mesh;
}

// The inside of 4 x 3 x 2.5 m, one surface, with a door of 0.9 x 2 m in the wall y = 0.
TriangleMesh room_with_door(float sigma_m, unsigned seed) {
  TriangleMesh mesh;
  add_lattice(mesh, {4, 3}, [](float u, float v) { return Eigen::Vector3f(u, v, 0); });
  add_lattice(mesh, {3, 4}, [](float u, float v) { return Eigen::Vector3f(v, u, 2.5F); });
  add_lattice(mesh, {3, 2.5F}, [](float u, float v) { return Eigen::Vector3f(0, u, v); });
  add_lattice(mesh, {2.5F, 3}, [](float u, float v) { return Eigen::Vector3f(4, v, u); });
  add_lattice(mesh, {4, 2.5F}, [](float u, float v) { return Eigen::Vector3f(u, 3, v); });
  add_lattice(
      mesh, {2.5F, 4}, [](float u, float v) { return Eigen::Vector3f(v, 0, u); },
      [](float u, float v) { return u > 2.0F || v < 1.0F || v > 1.9F; });
  return measured(mesh, sigma_m, seed);
}

// Vertices - edges + triangles: 2 for a ball, less by one for each hole.
int euler(const TriangleMesh& mesh) {
  std::set<uint32_t> vertices;
  std::set<std::pair<uint32_t, uint32_t>> edges;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t side = 0; side < 3; ++side) {
      const uint32_t a = triangle[side], b = triangle[(side + 1) % 3];
      vertices.insert(a);
      edges.emplace(std::min(a, b), std::max(a, b));
    }
  }
  return static_cast<int>(vertices.size() + mesh.triangles.size()) - static_cast<int>(edges.size());
}

// What holds of every simplified mesh. Borders are polygons of fewer corners: not longer.
void expect_as_whole(const TriangleMesh& mesh, const Simplified& fewer) {
  const auto whole = marco::testing::wholeness(mesh), left = marco::testing::wholeness(fewer.mesh);
  EXPECT_LE(left.open_m, whole.open_m + 1e-4);  // sums of floats
  EXPECT_GE(left.open_m, 0.8 * whole.open_m);
  EXPECT_LE(left.of_more, whole.of_more);
  EXPECT_EQ(euler(fewer.mesh), euler(mesh));
  EXPECT_LE(marco::testing::second_sheets(fewer.mesh)[0], 0.001);
  EXPECT_LE(fewer.there_m, 0.01);
  EXPECT_LE(fewer.back_m, 0.01);
  // Again, independently and finer.
  EXPECT_LE(gap(mesh, MeshDistance(fewer.mesh, 0.05F), 1e-4F).max_m, 0.01);
  EXPECT_LE(gap(fewer.mesh, MeshDistance(mesh, 0.05F), 1e-4F).max_m, 0.01);
}

TEST(SimplifyTopology, ARoomWithADoorIsStillOneSurfaceWithOneHole) {
  const TriangleMesh mesh = room_with_door(0.002F, 11);
  ASSERT_EQ(euler(mesh), 1);
  const std::vector<SurfacePlane> planes = find_planes(mesh);
  ASSERT_EQ(planes.size(), 6U);
  const Simplified fewer = simplify(mesh, planes);
  EXPECT_LT(fewer.mesh.triangles.size(), mesh.triangles.size() / 20);
  expect_as_whole(mesh, fewer);
  // Vertices that noise moved by no more than snapping may lie on a plane, in float to 1 um; at
  // edges, where they face between, on most of those near them.
  std::size_t on_all = 0;
  for (const Eigen::Vector3f& at : fewer.mesh.vertices_m) {
    double nearest_m = 1.0, farthest_m = 0.0;
    for (const SurfacePlane& plane : planes) {
      const double off_m = std::abs(plane.normal.dot(at.cast<double>()) - plane.offset_m);
      nearest_m = std::min(nearest_m, off_m);
      if (off_m < 0.005) farthest_m = std::max(farthest_m, off_m);
    }
    EXPECT_TRUE(nearest_m < 1e-6 || nearest_m > 0.005) << at.transpose();
    on_all += farthest_m < 1e-6 ? 1 : 0;
  }
  EXPECT_GE(on_all + 5, fewer.mesh.vertices_m.size());
}

// A metre of wall beside three that stand 3 mm before it, too far to be snapped, near enough to be
// cheap: no triangle may lead from these far onto the wall.
TEST(SimplifyTopology, AWallStaysFlatBesideWhatIsOffIt) {
  TriangleMesh mesh;
  add_lattice(mesh, {4, 3},
              [&](float u, float v) { return Eigen::Vector3f(u, v, u < 1.01F ? 0.0F : 0.003F); });
  mesh = measured(mesh, 0.0F, 19);
  std::vector<SurfacePlane> planes(1);
  planes[0].low_m = {-5, -5};
  planes[0].high_m = {5, 5};
  SimplifyOptions options;
  options.snap_share = 0.1;
  const Simplified fewer = simplify(mesh, planes, options);
  EXPECT_LT(fewer.mesh.triangles.size(), mesh.triangles.size() / 20);
  expect_as_whole(mesh, fewer);
  const MeshDistance distance(fewer.mesh, 0.05F);
  for (const Eigen::Vector3f& at : mesh.vertices_m) {
    if (at.x() > 1.01F) continue;
    EXPECT_LT(distance(at), 1e-5F) << at.transpose();
  }
}

TEST(SimplifyTopology, ATerrainKeepsItsCrease) {
  TriangleMesh mesh;
  add_lattice(mesh, {4, 2}, [](float u, float v) {
    return Eigen::Vector3f(u, v, 0.5F * std::abs(u - 2.0F) + 0.1F * std::sin(3.0F * v));
  });
  mesh = measured(mesh, 0.001F, 12);
  const Simplified fewer = simplify(mesh);
  EXPECT_LT(fewer.mesh.triangles.size(), mesh.triangles.size() / 3);
  expect_as_whole(mesh, fewer);
}

TEST(SimplifyTopology, HolesAndThinStripsBetweenBordersStay) {
  TriangleMesh mesh;
  // Windows in rows, the strips between them two lattice steps wide.
  const auto in_window = [](float at) { return std::fmod(at, 0.5F) > 0.1F; };
  add_lattice(
      mesh, {3.1F, 2.1F}, [](float u, float v) { return Eigen::Vector3f(u, v, 0); },
      [&](float u, float v) { return !in_window(u) || !in_window(v); });
  mesh = measured(mesh, 0.001F, 13);
  ASSERT_EQ(euler(mesh), 1 - 6 * 4);
  const Simplified fewer = simplify(mesh, find_planes(mesh));
  EXPECT_LT(fewer.mesh.triangles.size(), mesh.triangles.size() / 4);
  expect_as_whole(mesh, fewer);
}

TEST(SimplifyTopology, APostOnAFloorStaysRound) {
  TriangleMesh mesh;
  constexpr float kRadiusM = 0.06F;
  add_lattice(mesh, {2, 2}, [](float u, float v) { return Eigen::Vector3f(u - 1, v - 1, 0); });
  // 20 columns about the post; the last closes it.
  add_lattice(mesh, {1, 1.5F}, [](float u, float v) {
    const double angle_rad = 2.0 * M_PI * std::round(20.0 * static_cast<double>(u)) / 20.0;
    return Eigen::Vector3f(kRadiusM * static_cast<float>(std::cos(angle_rad)),
                           kRadiusM * static_cast<float>(std::sin(angle_rad)), v + 0.1F);
  });
  for (Eigen::Vector3f& at : mesh.vertices_m) at = (1e5F * at).array().round().matrix() / 1e5F;
  mesh = measured(mesh, 0.0005F, 14);
  ASSERT_EQ(euler(mesh), 1);  // a sheet has 1, a tube 0
  const Simplified fewer = simplify(mesh, find_planes(mesh));
  EXPECT_LT(fewer.mesh.triangles.size(), mesh.triangles.size() / 10);
  expect_as_whole(mesh, fewer);
}

TEST(SimplifyTopology, WallsThatMeetInAnEdgeStayTogether) {
  TriangleMesh mesh;
  add_lattice(mesh, {2, 1}, [](float u, float v) { return Eigen::Vector3f(u, v, 0); });
  add_lattice(mesh, {1, 1}, [](float u, float v) { return Eigen::Vector3f(1, v, u); });
  mesh = measured(mesh, 0.001F, 15);
  const auto whole = marco::testing::wholeness(mesh);
  EXPECT_EQ(whole.of_more, 20U);
  const Simplified fewer = simplify(mesh, find_planes(mesh));
  EXPECT_LT(fewer.mesh.triangles.size(), mesh.triangles.size() / 8);
  expect_as_whole(mesh, fewer);
  EXPECT_EQ(marco::testing::wholeness(fewer.mesh).of_more, 20U);
}

// The mean error of the heavy vertices around it hides a spike, the bound does not.
TEST(SimplifyTopology, ASpikeInAWallStays) {
  TriangleMesh mesh;
  add_lattice(mesh, {4, 4}, [](float u, float v) {
    const bool is_tip = std::abs(u - 2.0F) + std::abs(v - 2.0F) < 0.01F;
    return Eigen::Vector3f(u, v, is_tip ? 0.03F : 0.0F);
  });
  mesh = measured(mesh, 0.0F, 17);
  expect_as_whole(mesh, simplify(mesh));
}

// Bays of 2 x 4 cm: what fills them covers every sample, but lies where nothing was.
TEST(SimplifyTopology, BaysOfABorderAreNotFilled) {
  TriangleMesh mesh;
  add_lattice(
      mesh, {4, 4}, [](float u, float v) { return Eigen::Vector3f(0.4F * u, 0.4F * v, 0); },
      [](float u, float v) { return v < 3.95F || std::fmod(u, 0.2F) > 0.1F; });
  mesh = measured(mesh, 0.0005F, 18);
  expect_as_whole(mesh, simplify(mesh, find_planes(mesh)));
}

TEST(SimplifyTopology, ASoupOfTrianglesBecomesOneSurface) {
  const TriangleMesh mesh = room_with_door(0.002F, 16);
  TriangleMesh soup;
  for (const auto& triangle : mesh.triangles) {
    const auto first = static_cast<uint32_t>(soup.vertices_m.size());
    const auto& at = mesh.vertices_m;
    const Eigen::Vector3f normal =
        (at[triangle[1]] - at[triangle[0]]).cross(at[triangle[2]] - at[triangle[0]]).normalized();
    for (const uint32_t corner : triangle) {
      soup.vertices_m.push_back(at[corner]);
      soup.normals.push_back(normal);
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const Simplified fewer = simplify(soup, find_planes(soup));
  EXPECT_LT(fewer.mesh.triangles.size(), mesh.triangles.size() / 20);
  expect_as_whole(mesh, fewer);
}

}  // namespace
}  // namespace marco::mapping3d
