#include "mapping3d/surface/collapsing_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping3d/surface/laid_on_planes.hpp"
#include "mapping3d/surface/quadric.hpp"
#include "mapping3d/surface/welded.hpp"

namespace marco::mapping3d {
namespace {

using ::testing::UnorderedElementsAre;
using Triangles = std::vector<CollapsingMesh::Triangle>;

std::size_t count(const CollapsingMesh& mesh) {
  std::size_t there = 0;
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t) there += mesh.is_gone(t) ? 0 : 1;
  return there;
}

// Vertex 0 amid a ring of 1 to 6.
Triangles fan() {
  Triangles triangles;
  for (uint32_t i = 1; i <= 6; ++i) triangles.push_back({0, i, i % 6 + 1});
  return triangles;
}

TEST(CollapsingMesh, MovesAnInnerVertexOntoAnyNeighbour) {
  CollapsingMesh mesh(fan(), 7);
  std::vector<uint32_t> found;
  mesh.neighbours(0, found);
  EXPECT_THAT(found, UnorderedElementsAre(1, 2, 3, 4, 5, 6));
  ASSERT_TRUE(mesh.can_move(0, 4));
  mesh.move(0, 4);
  EXPECT_EQ(count(mesh), 4U);
  EXPECT_TRUE(mesh.is_alone(0));
  mesh.neighbours(4, found);
  EXPECT_THAT(found, UnorderedElementsAre(1, 2, 3, 5, 6));
  EXPECT_EQ(mesh.triangles_between(4, 1), 2U);
  EXPECT_EQ(mesh.triangles_between(4, 5), 1U);
}

TEST(CollapsingMesh, MovesABorderAlongItselfOnly) {
  CollapsingMesh mesh(fan(), 7);
  EXPECT_TRUE(mesh.is_on_border(1));
  EXPECT_FALSE(mesh.is_on_border(0));
  EXPECT_TRUE(mesh.can_move(1, 2));
  EXPECT_FALSE(mesh.can_move(1, 0));  // the border would bend inwards
  EXPECT_FALSE(mesh.can_move(1, 4));  // no neighbour
  // A cut across a strip has both ends on its borders.
  CollapsingMesh strip({{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {3, 5, 4}}, 6);
  EXPECT_FALSE(strip.can_move(2, 3));
  EXPECT_TRUE(strip.can_move(2, 0));
}

TEST(CollapsingMesh, ClosesNoHole) {
  // A ring of six triangles about a hole of three edges, 0 1 2.
  CollapsingMesh mesh({{0, 1, 3}, {1, 4, 3}, {1, 2, 4}, {2, 5, 4}, {2, 0, 5}, {0, 3, 5}}, 6);
  EXPECT_FALSE(mesh.can_move(0, 1));
  EXPECT_FALSE(mesh.can_move(1, 2));
}

TEST(CollapsingMesh, LetsNoPieceVanish) {
  CollapsingMesh alone({{0, 1, 2}}, 3);
  EXPECT_FALSE(alone.can_move(0, 1));
  CollapsingMesh tetrahedron({{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}, 4);
  for (uint32_t onto = 1; onto < 4; ++onto) EXPECT_FALSE(tetrahedron.can_move(0, onto));
  // An ear is cut from what is left.
  CollapsingMesh two({{0, 1, 2}, {1, 3, 2}}, 4);
  ASSERT_TRUE(two.can_move(0, 1));
  two.move(0, 1);
  EXPECT_EQ(count(two), 1U);
  EXPECT_FALSE(two.can_move(3, 1));
}

TEST(CollapsingMesh, LeavesVerticesWhereSurfacesMeet) {
  // Three leaves of an edge 0 1.
  CollapsingMesh book({{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}, 5);
  EXPECT_FALSE(book.can_ever_move(0));
  EXPECT_FALSE(book.can_ever_move(1));
  // Two rings of vertex 0 that both lead over 1.
  CollapsingMesh eight({{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 4}, {0, 4, 5}, {0, 5, 1}}, 6);
  EXPECT_FALSE(eight.can_ever_move(0));
  // Two fans that touch in vertex 0.
  CollapsingMesh tie({{0, 1, 2}, {0, 3, 4}}, 5);
  EXPECT_FALSE(tie.can_ever_move(0));
  EXPECT_TRUE(tie.can_ever_move(1));
}

TEST(CollapsingMesh, BeginsWithoutTrianglesOfTwoVertices) {
  CollapsingMesh mesh({{0, 0, 1}, {0, 1, 2}}, 3);
  EXPECT_TRUE(mesh.is_gone(0));
  EXPECT_EQ(mesh.triangles_between(0, 1), 1U);
}

TEST(Quadric, IsTheMeanSquaredDistance) {
  // Origins at (0, 0, 2) and (1, 0, 0): the floor z = 1 and the wall x = -2, from these.
  Quadric floor, wall;
  floor.add(Eigen::Vector3f::UnitZ(), {5, 3, -1}, 3.0F);
  wall.add(Eigen::Vector3f::UnitX(), {-3, 0, 7}, 1.0F);
  // At (-1.8, 7, 1.5): 0.5 m above the floor, 0.2 m before the wall: (3 * 0.25 + 0.04) / 4.
  EXPECT_NEAR(floor.mean_with(wall, {-1.8F, 7.0F, -0.5F}, {-2.8F, 7.0F, 1.5F}), 0.1975, 1e-6);
  floor.add(wall, {1, 0, -2});
  EXPECT_NEAR(floor.mean_with(Quadric(), {-1.8F, 7.0F, -0.5F}, {0, 0, 0}), 0.1975, 1e-6);
  EXPECT_NEAR(floor.weight(), 4.0, 1e-6);
  EXPECT_EQ(Quadric().mean_with(Quadric(), {0, 0, 0}, {0, 0, 0}), 0.0);
}

SurfacePlane plane(const Eigen::Vector3d& normal, double offset_m) {
  SurfacePlane plane;
  plane.normal = normal.normalized();
  plane.offset_m = offset_m;
  plane.along = plane.normal.unitOrthogonal();
  plane.across = plane.normal.cross(plane.along);
  plane.low_m = {-9, -9};
  plane.high_m = {9, 9};
  return plane;
}

// One plane after the other would leave the first, for they are not square.
TEST(LaidOnPlanes, ACornersVertexLiesOnBothPlanes) {
  const std::vector<SurfacePlane> planes{plane({0, 0, 1}, 0.0), plane({1, 0, 1}, 0.0)};
  TriangleMesh mesh;
  mesh.vertices_m = {{0.002F, 1, 0.002F}, {0.002F, 1, 0.1F}};
  mesh.normals.assign(2, Eigen::Vector3f(0.4F, 0, 0.9F).normalized());
  const LaidOnPlanes laid = laid_on_planes(mesh, planes, 0.005);
  EXPECT_EQ(laid.planes[0].count(), 2U);
  for (const SurfacePlane& each : planes) {
    EXPECT_NEAR(each.normal.dot(laid.vertices_m[0].cast<double>()), each.offset_m, 1e-6);
  }
  EXPECT_EQ(laid.planes[1].count(), 0U);  // too far from both
  EXPECT_EQ(laid.vertices_m[1], mesh.vertices_m[1]);
  EXPECT_TRUE(laid.planes[1].are_all_of(laid.planes[0]));
  EXPECT_FALSE(laid.planes[0].are_all_of(laid.planes[1]));
}

TEST(LaidOnPlanes, OfTwoParallelOnesTheFirstHolds) {
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}};
  mesh.normals = {Eigen::Vector3f::UnitZ()};
  const LaidOnPlanes laid =
      laid_on_planes(mesh, {plane({0, 0, 1}, 0.003), plane({0, 0, 1}, 0.004)}, 0.005);
  EXPECT_EQ(laid.planes[0].count(), 1U);
  EXPECT_NEAR(laid.vertices_m[0].z(), 0.003F, 1e-7F);
}

TEST(Welded, AVertexOfAPlaceHasTheMeanNormal) {
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, -0.0F, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1}, {1, 0, 0}};
  mesh.colors_rgb.assign(6, {1, 2, 3});
  mesh.triangles = {{0, 1, 2}, {3, 5, 4}};
  const TriangleMesh one = welded(mesh).value();
  ASSERT_EQ(one.vertices_m.size(), 4U);
  EXPECT_EQ(one.triangles[0][1], one.triangles[1][0]);
  EXPECT_EQ(one.triangles[0][2], one.triangles[1][2]);
  EXPECT_TRUE(one.normals[one.triangles[0][1]].isApprox(Eigen::Vector3f(1, 0, 1).normalized()));
  EXPECT_EQ(one.colors_rgb.size(), 4U);
}

}  // namespace
}  // namespace marco::mapping3d
