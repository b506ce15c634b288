#include "tools/watch/live_map.hpp"

#include <gtest/gtest.h>

namespace marco::watch {
namespace {

GridMap tile(double x_m, double y_m, int width, int height, uint8_t value) {
  GridMap grid;
  grid.origin_m = {x_m, y_m};
  grid.resolution_m = 0.5;
  grid.width_cells = width;
  grid.height_cells = height;
  grid.occupancy.assign(static_cast<std::size_t>(width * height), value);
  return grid;
}

TEST(LiveMap, TheWayIsSlamsAndFollowsItsCorrections) {
  LiveMap map;
  EXPECT_FALSE(map.scene().has_value());
  const auto at = [](int64_t s) { return Utime::from_us(s * 1'000'000); };
  for (int i = 0; i < 6; ++i) map.add_pose(at(10 + i), {0.1 * i, 0.0, 0.0});
  map.add_pose(at(12), {9.0, 9.0, 0.0});  // older than the last: not taken
  EXPECT_EQ(map.poses(), 6U);
  map.set_trajectory({{at(10), {0.0, 1.0, 0.0}}, {at(13), {0.3, 1.0, 0.0}}});
  EXPECT_EQ(map.poses(), 4U);  // two key poses and the two since
  const auto scene = map.scene();
  ASSERT_TRUE(scene.has_value());
  EXPECT_EQ(scene->paths.at(0).poses.front().world_from_robot.y_m, 1.0);
  EXPECT_EQ(scene->paths.at(0).poses.back().world_from_robot.x_m, 0.5);
  EXPECT_LE(scene->paths.at(0).longest_step_m, 2.0);
  EXPECT_EQ(scene->robots.at(0).world_from_robot.x_m, 0.5);
}

// Whoever sends it: a grid round both would take 4e12 cells.
TEST(LiveMap, AStrayTileIsRefusedAndThreeOfThemAreANewMap) {
  LiveMap map;
  map.add_tile(tile(0.0, 0.0, 256, 256, 10), 1);
  for (int i = 0; i < 2; ++i) {
    EXPECT_THROW(map.add_tile(tile(128e4, 0.0, 256, 256, 90), 1), std::invalid_argument);
    EXPECT_EQ(map.scene()->grid->width_cells, 256);
  }
  map.add_tile(tile(128.0, 0.0, 256, 256, 10), 1);
  EXPECT_EQ(map.scene()->grid->width_cells, 512);
  for (int i = 0; i < 2; ++i) {
    EXPECT_THROW(map.add_tile(tile(-128e3, 128e3, 256, 256, 90), 1), std::invalid_argument);
  }
  map.add_tile(tile(-128e3, 128e3, 256, 256, 90), 1);
  EXPECT_EQ(map.scene()->grid->origin_m, Eigen::Vector2d(-128e3, 128e3));
}

TEST(LiveMap, ATileOfAnotherResolutionBeginsANewMap) {
  LiveMap map;
  map.add_tile(tile(0.0, 0.0, 256, 256, 10), 1);
  GridMap finer = tile(0.0, 128.0, 256, 256, 10);
  finer.resolution_m = 0.25;
  map.add_tile(finer, 1);
  EXPECT_EQ(map.scene()->grid->height_cells, 256);
  EXPECT_EQ(map.scene()->grid->resolution_m, 0.25);
}

}  // namespace
}  // namespace marco::watch
