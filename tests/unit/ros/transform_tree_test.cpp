#include "recordings/ros/transform_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace marco::ros {
namespace {

TransformMessage transform(const std::string& parent, const std::string& child, const Pose3& pose) {
  return {{0, parent}, child, pose};
}
Pose3 at(double x_m, double yaw_rad = 0.0) { return make_pose3({x_m, 0, 0}, 0, 0, yaw_rad); }

TEST(TransformTree, FindsASensorsPlaceOverSeveralFrames) {
  TransformTree tree;
  tree.add(transform("base_footprint", "base_link", at(0.0)), true);
  tree.add(transform("base_link", "mount", at(0.2, std::numbers::pi / 2)), true);
  tree.add(transform("mount", "laser", at(0.1)), false);
  const auto pose = tree.fixed_pose("base_footprint", "laser");
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->translation().x(), 0.2, 1e-12);
  EXPECT_NEAR(pose->translation().y(), 0.1, 1e-12);
  EXPECT_NEAR(flatten(*pose).theta_rad, std::numbers::pi / 2, 1e-12);
  // And the other way round, and between branches.
  tree.add(transform("base_link", "camera", at(0.5)), true);
  EXPECT_TRUE(tree.fixed_pose("laser", "camera"));
  EXPECT_FALSE(tree.fixed_pose("laser", "elsewhere"));
}

TEST(TransformTree, WhatIsRepeatedWithoutMovingIsFixed) {
  TransformTree tree;
  for (int i = 0; i < 100; ++i) tree.add(transform("base", "laser", at(0.3)), false);
  EXPECT_FALSE(tree.above("laser")->moves());
  tree.add(transform("base", "laser", at(0.3, 0.2)), false);
  EXPECT_TRUE(tree.above("laser")->moves());
  EXPECT_FALSE(tree.fixed_pose("base", "laser"));
}

TEST(TransformTree, DropsWhatTfDrops) {
  TransformTree tree;
  tree.add(transform("a", "a", at(1.0)), true);
  tree.add(transform("", "a", at(1.0)), true);
  tree.add(transform("a", "b", at(std::nan(""))), true);
  EXPECT_TRUE(tree.edges().empty());
  Pose3 pose;
  EXPECT_FALSE(make_pose({0, 0, 0}, {0, 0, 0, 0}, pose));
  EXPECT_FALSE(make_pose({0, 0, 0}, {0, 0, 0, 1.1}, pose));
  EXPECT_TRUE(make_pose({0, 0, 0}, {0, 0, 0, 1.001}, pose));
}

TEST(TransformTree, EndsInARing) {
  TransformTree tree;
  tree.add(transform("a", "b", at(1.0)), true);
  tree.add(transform("b", "a", at(1.0)), true);
  EXPECT_LE(tree.way_up("a").size(), 2U);
  EXPECT_FALSE(tree.fixed_pose("a", "c"));
}

}  // namespace
}  // namespace marco::ros
