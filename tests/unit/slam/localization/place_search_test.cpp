#include "slam/localization/place_search.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

// A map of walls 12 x 9 m with cells of 10 cm, and a scan's points about their middle.
class PlaceSearchTest : public ::testing::Test {
 protected:
  static CorrelativeMatcherOptions table() {
    CorrelativeMatcherOptions options;
    options.resolution_m = 0.1;
    options.blur_m = 0.1;
    return options;
  }
  static Points2 walls() {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    testing::FlatWorld world = testing::small_room();
    world.add_box(5.0, -4.0, 8.0, 2.0);
    Points2 points(2, 1500);
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const auto& wall = world.walls[static_cast<std::size_t>(i) % world.walls.size()];
      points.col(i) = wall.from + part(random) * (wall.to - wall.from);
    }
    return points;
  }
  LikelihoodPyramid map_{walls(), table()};
};

TEST_F(PlaceSearchTest, ABlocksBoundIsTheSumOfWhatTheMapSays) {
  std::mt19937 random(9);
  std::uniform_int_distribution<int> far(-300, 300);
  for (const int max_blocks : {100000, 900, 40}) {
    const BlockTable blocks(map_, max_blocks);
    const int side = 1 << blocks.level();
    std::vector<uint16_t> sums(static_cast<std::size_t>(blocks.stride() * blocks.rows()));
    std::vector<int> expected(sums.size());
    for (int point = 0; point < 60; ++point) {
      const int x = far(random), y = far(random);
      blocks.add(x, y, sums.data());
      for (int row = 0; row < blocks.rows(); ++row) {
        for (int column = 0; column < blocks.columns(); ++column) {
          expected[static_cast<std::size_t>(row * blocks.stride() + column)] +=
              map_.at(blocks.level(), column * side + x, row * side + y);
        }
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) ASSERT_EQ(sums[i], expected[i]) << i;
  }
}

TEST_F(PlaceSearchTest, FindsTheBestPoseOfAll) {
  const BlockTable blocks(map_, 500);
  const Pose2 truth{0.4, -0.3, 2.1};
  Points2 scan = truth.inverse() * walls();
  Points2 few(2, 60);
  for (Eigen::Index i = 0; i < few.cols(); ++i) few.col(i) = scan.col(25 * i);
  PlaceSearch search(map_, blocks, few, {0.5, 0.1});
  const std::vector<Pose2> places = search.run(5);
  ASSERT_FALSE(places.empty());
  const Pose2 off = between(truth, places.front());
  // A cell, and the turn that moves a point at half the scan's reach by one.
  EXPECT_LT(off.translation_m().norm(), 0.15);
  EXPECT_LT(std::abs(off.theta_rad), 0.05);
}

}  // namespace
}  // namespace marco::slam
