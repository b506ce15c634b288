#include "common/map_tiles.hpp"

#include <gtest/gtest.h>

namespace marco {
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

TEST(MapTiles, AreJoinedWhereTheyLie) {
  EXPECT_FALSE(join_tiles({}, 1e9));
  const GridMap low = tile(0.0, 0.0, 4, 2, 10), right = tile(2.0, 0.0, 2, 2, 90),
                left = tile(-1.0, 1.0, 2, 1, 50);
  const GridMap all = join_tiles({&low, &right, &left}, 1e9).value();
  EXPECT_EQ(all.width_cells, 8);
  EXPECT_EQ(all.height_cells, 3);
  EXPECT_EQ(all.origin_m, Eigen::Vector2d(-1.0, 0.0));
  EXPECT_EQ(all.at(2, 0), 10);
  EXPECT_EQ(all.at(5, 1), 10);
  EXPECT_EQ(all.at(6, 1), 90);
  EXPECT_EQ(all.at(1, 2), 50);
  EXPECT_EQ(all.at(0, 0), GridMap::kUnknown);
  EXPECT_EQ(all.at(2, 2), GridMap::kUnknown);
  EXPECT_TRUE(join_tiles({&low, &right, &left}, 24));
  EXPECT_FALSE(join_tiles({&low, &right, &left}, 23));
}

}  // namespace
}  // namespace marco
