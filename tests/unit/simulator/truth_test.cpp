#include "simulator/truth.hpp"

#include <gtest/gtest.h>

namespace marco::sim {
namespace {

World floor_and_wall() {
  World world;
  world.add_quad({Eigen::Vector3d(-5, -5, 0), {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}, Material::plain);
  world.add_quad({Eigen::Vector3d(3, -5, 0), {3, 5, 0}, {3, 5, 3}, {3, -5, 3}}, Material::plain);
  return world;
}

TEST(ModelError, IsTheDistanceOfEveryPartOfItsSurface) {
  const RayCaster world(floor_and_wall());
  TriangleMesh model;  // a metre square 20 mm above the floor
  model.vertices_m = {{0, 0, 0.02F}, {1, 0, 0.02F}, {1, 1, 0.02F}, {0, 1, 0.02F}};
  model.triangles = {{0, 1, 2}, {0, 2, 3}};
  const SurfaceError error = model_error(model, world, Pose3::Identity());
  EXPECT_NEAR(error.rms_m, 0.02, 1e-6);
  EXPECT_NEAR(error.p99_m, 0.02, 1e-6);
  EXPECT_NEAR(static_cast<double>(error.count), 2500, 2);  // a point each 4 cm2
  // Lowered by its pose it lies on the floor.
  EXPECT_NEAR(model_error(model, world, make_pose3({0, 0, -0.02})).rms_m, 0.0, 1e-6);
}

TEST(ModelError, ALargeTriangleIsJudgedAllOverNotAtItsCorners) {
  const RayCaster world(floor_and_wall());
  TriangleMesh model;  // from floor to wall: its corners touch, its middle hangs in the air
  model.vertices_m = {{1, 0, 0}, {3, 0, 2}, {3, 0.5F, 2}};
  model.triangles = {{0, 1, 2}};
  EXPECT_GT(model_error(model, world, Pose3::Identity()).rms_m, 0.3);
}

TEST(MapError, OccupiedCellsAreMeasuredAtTheLasersHeight) {
  const RayCaster world(floor_and_wall());
  GridMap map;
  map.resolution_m = 0.1;
  map.width_cells = 3;
  map.height_cells = 1;
  map.origin_m = {2.75, 0.0};
  map.occupancy = {100, 50, GridMap::kUnknown};  // its centre: 2.8, 0.2 m from the wall
  const SurfaceError error = map_error(map, world, Pose2{}, 0.5);
  EXPECT_EQ(error.count, 1U);
  EXPECT_NEAR(error.rms_m, 0.2, 1e-5);
  EXPECT_NEAR(map_error(map, world, Pose2{0.2, 0, 0}, 0.5).rms_m, 0.0, 1e-5);
}

}  // namespace
}  // namespace marco::sim
