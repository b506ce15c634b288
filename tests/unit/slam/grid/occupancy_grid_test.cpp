#include "slam/grid/occupancy_grid.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace marco::slam {
namespace {

Points2 point(double x_m, double y_m) { return Eigen::Vector2d(x_m, y_m); }

OccupancyGridOptions coarse() {
  OccupancyGridOptions options;
  options.resolution_m = 1.0;
  options.max_free_range_m = 100.0;
  return options;
}

TEST(OccupancyGrid, ABeamClearsItsWayAndMarksItsEnd) {
  OccupancyGrid grid(coarse());
  grid.insert(point(4.5, 0.5), {0.5, 0.5});
  for (const double x_m : {0.5, 1.5, 2.5, 3.5})
    EXPECT_NEAR(grid.probability({x_m, 0.5}), 0.4, 1e-6);
  EXPECT_NEAR(grid.probability({4.5, 0.5}), 0.7, 1e-6);
  EXPECT_EQ(grid.probability({5.5, 0.5}), 0.5);
  EXPECT_EQ(grid.probability({2.5, 1.5}), 0.5);
}

TEST(OccupancyGrid, ABeamClearsCellsOnlyWithinItsFreeRange) {
  OccupancyGridOptions options = coarse();
  options.max_free_range_m = 3.0;
  OccupancyGrid grid(options);
  grid.insert(point(8.5, 0.5), {0.5, 0.5});
  // From 0.5 m the range ends at 3.5 m, in the fourth cell, which a beam's last cell is not part
  // of.
  for (const double x_m : {0.5, 1.5, 2.5}) EXPECT_NEAR(grid.probability({x_m, 0.5}), 0.4, 1e-6);
  for (const double x_m : {3.5, 4.5, 5.5, 6.5, 7.5}) {
    EXPECT_EQ(grid.probability({x_m, 0.5}), 0.5) << x_m;
  }
  EXPECT_NEAR(grid.probability({8.5, 0.5}), 0.7, 1e-6);
}

// A hit a hundred kilometres away must not cost a map of that size.
TEST(OccupancyGrid, WhatWouldMakeTheMapTooLargeIsLeftOutAndSaid) {
  OccupancyGrid grid;
  grid.insert(point(4.5, 0.5), {0.5, 0.5});
  EXPECT_FALSE(grid.too_large_m().has_value());
  Points2 hits(2, 3);
  hits << 1e5, 3.0, 0.5,  //
      1e5, 0.5, -2e9;
  grid.insert(hits, {0.5, 0.5});
  grid.insert(point(1e5 + 1.0, 0.0), {1e5, 0.0});
  ASSERT_TRUE(grid.too_large_m().has_value());
  EXPECT_NEAR(grid.too_large_m()->x(), 1e5, 100.0);
  const GridMap map = grid.to_map();
  EXPECT_LT(map.width_cells, 100);
  EXPECT_LT(map.height_cells, 2);
  EXPECT_GT(grid.probability({3.0, 0.5}), 0.5);
  EXPECT_EQ(grid.probability({1e5, 1e5}), 0.5);
  // As wide as it may be, a corridor is drawn.
  OccupancyGrid corridor;
  for (int i = 0; i < 20; ++i) corridor.insert(point(100.0 * i + 20.0, 0.5), {100.0 * i, 0.5});
  EXPECT_FALSE(corridor.too_large_m().has_value());
  EXPECT_EQ(corridor.to_map().width_cells, 1920 * 20 + 1);
}

TEST(OccupancyGrid, OneScanCountsOnceACellAndAHitWins) {
  OccupancyGrid grid(coarse());
  Points2 hits(2, 3);
  hits << 2.2, 2.8, 4.5,  //
      0.5, 0.5, 0.5;      // twice the same cell, and a beam through it
  grid.insert(hits, {0.5, 0.5});
  EXPECT_NEAR(grid.probability({2.5, 0.5}), 0.7, 1e-6);
  EXPECT_NEAR(grid.probability({1.5, 0.5}), 0.4, 1e-6);
}

TEST(OccupancyGrid, EvidenceIsBoundedSoThatADoorCanOpen) {
  OccupancyGrid grid(coarse());
  for (int i = 0; i < 100; ++i) grid.insert(point(2.5, 0.5), {0.5, 0.5});
  EXPECT_NEAR(grid.probability({2.5, 0.5}), 0.98, 1e-6);
  for (int i = 0; i < 12; ++i) grid.insert(point(6.5, 0.5), {0.5, 0.5});
  EXPECT_LT(grid.probability({2.5, 0.5}), 0.5);
}

// Every cell that holds one of many samples along the beam, its end excepted.
std::set<std::pair<int, int>> sampled_cells(Eigen::Vector2d from, Eigen::Vector2d to) {
  std::set<std::pair<int, int>> cells;
  for (int i = 0; i <= 20000; ++i) {
    const Eigen::Vector2d at = from + (to - from) * i / 20000.0;
    cells.emplace(static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())));
  }
  cells.erase({static_cast<int>(std::floor(to.x())), static_cast<int>(std::floor(to.y()))});
  return cells;
}

TEST(OccupancyGrid, ClearsTheCellsABeamCrossesInEveryDirection) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-20.0, 20.0);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d from(uniform(random), uniform(random)),
        to(uniform(random), uniform(random));
    OccupancyGrid grid(coarse());
    grid.insert(to, from);
    const GridMap map = grid.to_map();
    std::set<std::pair<int, int>> freed;
    for (int y = 0; y < map.height_cells; ++y) {
      for (int x = 0; x < map.width_cells; ++x) {
        if (map.at(x, y) < 50) {
          freed.emplace(x + static_cast<int>(map.origin_m.x()),
                        y + static_cast<int>(map.origin_m.y()));
        }
      }
    }
    EXPECT_EQ(freed, sampled_cells(from, to)) << from.transpose() << " to " << to.transpose();
  }
}

TEST(OccupancyGrid, TheMapHoldsWhatIsKnownWhereItIs) {
  OccupancyGrid grid;
  EXPECT_EQ(grid.to_map().width_cells, 0);
  grid.insert(point(-3.02, 1.01), {-3.02, 0.01});
  const GridMap map = grid.to_map();
  EXPECT_EQ(map.width_cells, 1);
  EXPECT_EQ(map.height_cells, 21);
  const Eigen::Vector2i cell = map.cell_of({-3.02, 1.01});
  EXPECT_EQ(map.at(cell.x(), cell.y()), 70);
  EXPECT_EQ(map.at(0, 0), 40);
}

TEST(OccupancyGrid, RefusesPointsThatAreNotFinite) {
  OccupancyGrid grid;
  EXPECT_THROW(grid.insert(point(std::nan(""), 0), {0, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace marco::slam
