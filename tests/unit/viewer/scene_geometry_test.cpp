#include "viewer/scene_geometry.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/viewer/tiny_room.hpp"

namespace marco::viewer {
namespace {

TEST(SceneGeometry, LeavesOutTrianglesThatPointNowhere) {
  TriangleMesh mesh = testing::make_room();
  const std::size_t whole = mesh.triangles.size();
  mesh.triangles.push_back({0, 1, 1000000});
  mesh.vertices_m.push_back(Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  mesh.triangles.push_back({0, 1, static_cast<uint32_t>(mesh.vertices_m.size() - 1)});
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(mesh)});
  EXPECT_EQ(build_geometry(scene).surfaces.indices.size(), 3 * whole);
}

TEST(SceneGeometry, ComputesNormalsThatFaceIntoTheRoom) {
  const SceneGeometry geometry = build_geometry(testing::room_scene());
  for (const Vertex& vertex : geometry.surfaces.vertices) {
    const bool on_floor = vertex.position_m[2] == 0.0F && vertex.normal[2] > 32000;
    const bool on_ceiling = vertex.position_m[2] == 2.5F && vertex.normal[2] < -32000;
    const bool upright = std::abs(vertex.normal[2]) < 5;
    const bool on_furniture = vertex.position_m[2] == 0.75F || vertex.position_m[2] == 1.8F;
    EXPECT_TRUE(on_floor || on_ceiling || upright || on_furniture);
  }
}

TEST(SceneGeometry, RunsOfLikeCellsBecomeOneFace) {
  Scene scene;
  GridMap grid;
  grid.width_cells = 5;
  grid.height_cells = 1;
  grid.occupancy = {0, 10, 100, 100, GridMap::kUnknown};
  scene.grid = grid;
  // Free run and wall run, two triangles each; the wall as a box has five faces.
  EXPECT_EQ(build_geometry(scene).props.indices.size(), 3U * 4U);
  scene.grid_wall_height_m = 2.0;
  EXPECT_EQ(build_geometry(scene).props.indices.size(), 3U * (2U + 10U));
}

}  // namespace
}  // namespace marco::viewer
