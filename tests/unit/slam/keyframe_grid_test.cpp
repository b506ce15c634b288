#include "slam/map/keyframe_grid.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco::slam {
namespace {

// Keyframes along a straight drive, each with some walls about it.
std::vector<Keyframe> some_keys(int count) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-4.0, 4.0);
  std::vector<Keyframe> keys;
  for (int i = 0; i < count; ++i) {
    Keyframe key;
    key.utime = Utime::from_us(1000 * i);
    key.points_in_robot.points = Points2(2, 40);
    for (double& coordinate : key.points_in_robot.points.reshaped()) coordinate = place(random);
    key.world_from_robot = {0.3 * i, 0.0, 0.01 * i};
    keys.push_back(std::move(key));
  }
  return keys;
}

void expect_equal(const OccupancyGrid& a, const OccupancyGrid& b) {
  const GridMap left = a.to_map(), right = b.to_map();
  EXPECT_EQ(left.origin_m, right.origin_m);
  EXPECT_EQ(left.width_cells, right.width_cells);
  EXPECT_EQ(left.occupancy, right.occupancy);
}

TEST(KeyframeGrid, AddsNewScansToWhatIsDrawn) {
  const std::vector<Keyframe> keys = some_keys(12);
  KeyframeGrid growing;
  for (const std::size_t count : {3U, 4U, 9U, 12U}) {
    const std::vector<Keyframe> part(keys.begin(), keys.begin() + static_cast<int>(count));
    expect_equal(growing.update(part), draw_grid(part));
  }
  EXPECT_EQ(growing.times_redrawn(), 0);
}

TEST(KeyframeGrid, DrawsAnewWhatHasMovedOrIsAnother) {
  std::vector<Keyframe> keys = some_keys(8);
  KeyframeGrid grid;
  grid.update(keys);
  keys[2].world_from_robot.x_m += 0.02;  // less than half a cell of 5 cm
  grid.update(keys);
  EXPECT_EQ(grid.times_redrawn(), 0);
  keys[2].world_from_robot.theta_rad += 0.003;
  expect_equal(grid.update(keys), draw_grid(keys));
  EXPECT_EQ(grid.times_redrawn(), 1);
  keys.resize(5);
  expect_equal(grid.update(keys), draw_grid(keys));
  keys[4].utime = Utime::from_us(77);
  expect_equal(grid.update(keys), draw_grid(keys));
  EXPECT_EQ(grid.times_redrawn(), 3);
}

TEST(KeyframeGrid, OneInTheMidstThatBecameOneWithAnotherIsNoReasonToDrawAnew) {
  std::vector<Keyframe> keys = some_keys(8);
  KeyframeGrid grid;
  const OccupancyGrid all = draw_grid(keys);
  grid.update(keys);
  keys.erase(keys.begin() + 3);
  keys.erase(keys.begin() + 5);
  expect_equal(grid.update(keys), all);
  EXPECT_EQ(grid.times_redrawn(), 0);
  keys[1].world_from_robot.x_m += 0.1;
  expect_equal(grid.update(keys), draw_grid(keys));
  EXPECT_EQ(grid.times_redrawn(), 1);
}

TEST(KeyframeGrid, InPartsItShowsTheOldOneUntilTheNewOneIsComplete) {
  std::vector<Keyframe> keys = some_keys(8);
  KeyframeGrid grid;
  EXPECT_FALSE(grid.advance(keys, 5));
  EXPECT_TRUE(grid.advance(keys, 5));
  const OccupancyGrid before = draw_grid(keys);
  expect_equal(grid.grid(), before);
  keys[2].world_from_robot.x_m += 0.2;
  EXPECT_FALSE(grid.advance(keys, 3));
  keys[1].world_from_robot.x_m += 0.2;  // and what was drawn of the new one has moved again
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(grid.advance(keys, 3));
  expect_equal(grid.grid(), before);
  EXPECT_TRUE(grid.advance(keys, 3));
  expect_equal(grid.grid(), draw_grid(keys));
  EXPECT_EQ(grid.times_redrawn(), 1);
}

TEST(KeyframeGrid, OnlyTheTilesWhereOneMovedAreMadeAnew) {
  std::vector<Keyframe> keys = some_keys(200);  // 60 m; each reaches 6 m
  KeyframeGrid grid;
  grid.update(keys);
  ASSERT_EQ(grid.drawn(), 200);
  keys[190].world_from_robot.y_m += 0.3;
  keys[195].world_from_robot.y_m += 0.2;
  expect_equal(grid.update(keys), draw_grid(keys));
  EXPECT_EQ(grid.times_redrawn(), 1);
  EXPECT_GT(grid.drawn(), 200 + 20);
  EXPECT_LT(grid.drawn(), 200 + 80);
}

TEST(KeyframeGrid, WhatAKeyframeThatHasGoneDrewIsTakenOutOnceWithTheNextThatMoves) {
  std::vector<Keyframe> keys = some_keys(200);
  KeyframeGrid grid;
  grid.update(keys);
  keys.erase(keys.begin() + 20);
  grid.update(keys);
  const auto drawn_for_a_move = [&] {
    const int64_t before = grid.drawn();
    keys.back().world_from_robot.y_m += 0.3;
    expect_equal(grid.update(keys), draw_grid(keys));
    return grid.drawn() - before;
  };
  const int64_t with_the_gone = drawn_for_a_move();
  EXPECT_LT(drawn_for_a_move() + 20, with_the_gone);
}

TEST(KeyframeGrid, HoweverTheyMoveAndGrowItIsWhatAGridOfThemWouldBe) {
  const std::vector<Keyframe> all = some_keys(60);
  std::mt19937 random(9);
  std::vector<Keyframe> keys(all.begin(), all.begin() + 5);
  KeyframeGrid grid;
  for (int round = 0; round < 40; ++round) {
    if (keys.size() < all.size()) keys.push_back(all[keys.size()]);
    if (round % 3 == 0) keys[random() % keys.size()].world_from_robot.x_m += 0.5;
    if (round % 5 != 0) {
      grid.advance(keys, static_cast<int>(random() % 20));
    } else {
      expect_equal(grid.update(keys), draw_grid(keys));
    }
  }
  expect_equal(grid.update(keys), draw_grid(keys));
}

}  // namespace
}  // namespace marco::slam
