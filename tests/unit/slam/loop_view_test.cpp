// Loop closures by what the earlier visit could see.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "slam/back_end/loop_closer.hpp"
#include "tests/support/loop_candidate.hpp"

namespace marco::slam {
namespace {

Keyframe keyframe_at(const testing::FlatWorld& world, const Pose2& pose) {
  std::mt19937 random(2);
  Keyframe key;
  key.world_from_robot = pose;
  key.points_in_robot = orient(world.hits(pose, 0.01, &random), {0, 0}, {});
  return key;
}

// A corridor that ends, where there was a corridor that goes on.
TEST(LoopView, AWallInFreeSpaceRefusesALoop) {
  testing::FlatWorld corridor, with_end;
  corridor.add_chain({{-5, -1.5}, {12, -1.5}, {12, 1.5}, {-5, 1.5}});
  with_end.add_chain({{-5, -1.5}, {1.2, -1.5}, {1.2, 1.5}, {-5, 1.5}});
  LoopCloserOptions options;
  options.min_score = 0.3;
  const LoopCloser closer(options, CorrelativeMatcher(), SurfelMatcher());
  LoopCandidate candidate = testing::candidate_of(corridor, with_end, {}, {0.05, 0, 0}, 0.1);
  candidate.place_keys = {keyframe_at(corridor, {})};
  EXPECT_FALSE(closer.verify(candidate));
  candidate = testing::candidate_of(corridor, corridor, {}, {0.05, 0, 0}, 0.1);
  candidate.place_keys = {keyframe_at(corridor, {})};
  EXPECT_TRUE(closer.verify(candidate));
}

// The robot comes back and looks another way: two thirds of what it sees now it could not see then.
TEST(LoopView, WhatTheEarlierVisitCouldNotSeeDoesNotCount) {
  const testing::FlatWorld room = testing::small_room();
  const Pose2 turned{0.2, 0.1, deg_to_rad(95.0)};
  LoopCloserOptions options;
  options.min_score = 0.3;
  const LoopCloser closer(options, CorrelativeMatcher(), SurfelMatcher());
  LoopCandidate candidate = testing::candidate_of(room, room, turned, {0.1, 0.05, 0.02}, 0.2);
  EXPECT_FALSE(closer.verify(candidate)) << "nobody says what the earlier visit could see";
  candidate.place_keys = {keyframe_at(room, {})};
  const auto loop = closer.verify(candidate);
  ASSERT_TRUE(loop);
  EXPECT_LT((loop->from_from_to.translation_m() - turned.translation_m()).norm(), 0.02);
}

// A corridor that the robot left by its closed end and comes back into by the other: most of what
// the newer visit sees lies where the older one never looked. A search over all points pushes that
// part onto the walls that are known, metres along the corridor.
TEST(LoopView, TheSearchIsNotDrawnByWhatTheEarlierVisitCouldNotSee) {
  testing::FlatWorld corridor;
  corridor.add_chain({{25, 1.5}, {-12, 1.5}, {-12, -1.5}, {25, -1.5}});
  std::mt19937 random(6);
  std::vector<Keyframe> keys;
  const auto add = [&](double x_m, double heading_rad) {
    Keyframe key;
    key.world_from_robot = {x_m, 0.0, heading_rad};
    key.points_in_robot = orient(corridor.hits(key.world_from_robot, 0.01, &random), {0, 0}, {});
    keys.push_back(std::move(key));
  };
  for (const double x_m : {-2.0, -4.0, -6.0}) add(x_m, std::numbers::pi);
  add(-3.0, std::numbers::pi);  // the newer visit
  for (const double x_m : {-3.0, -2.0}) add(x_m, 0.0);
  LoopCandidate candidate;
  candidate.to = 5;
  candidate.world_from_old = keys[0].world_from_robot;
  candidate.world_from_newest = Pose2{0.1, 0.05, 0.0} * keys[5].world_from_robot;
  candidate.place = join_points(keys, 0, 2, {});
  candidate.seen = join_points(keys, 3, 5, keys[5].world_from_robot.inverse());
  candidate.covariance = diagonal_covariance(1.0, 0.05);
  candidate.place_keys = {keys.begin(), keys.begin() + 3};
  LoopCloserOptions options;
  options.unlikely_penalty = 0.0;
  const LoopCloser closer(options, CorrelativeMatcher(), SurfelMatcher());
  const auto loop = closer.verify(candidate);
  ASSERT_TRUE(loop);
  EXPECT_LT((loop->from_from_to.translation_m() -
             between(keys[0].world_from_robot, keys[5].world_from_robot).translation_m())
                .norm(),
            0.05);
}

// A corridor with doors, the older visit looking along it one way, the newer one the other: both
// see little of the same. A search over all points gains by each wall that it pushes onto the part
// of it that the older visit saw, and ends 0.16 m off.
TEST(LoopView, NoWallIsPushedOntoThePartThatWasSeen) {
  testing::FlatWorld office;
  office.add_chain({{0, 0}, {32, 0}, {32, 20}, {0, 20}, {0, 0}});
  office.add_chain({{4.5, 6}, {11, 6}});
  office.add_chain({{12, 6}, {20, 6}});
  office.add_chain({{21, 6}, {27.5, 6}});
  office.add_chain({{8, 0}, {8, 6}});
  office.add_chain({{15.5, 0}, {15.5, 6}});
  office.add_chain({{2.2, 12}, {2.2, 8}, {8, 8}});
  office.add_chain({{9, 8}, {23, 8}});
  office.add_chain({{2.2, 12}, {23, 12}});
  office.add_chain({{16.5, 8}, {16.5, 12}});
  std::mt19937 random(4);
  std::vector<Keyframe> keys;
  for (const Pose2& pose :
       {Pose2{9.19, 7.37, -0.427}, Pose2{9.46, 7.25, -0.427}, Pose2{9.74, 7.12, -0.427},
        Pose2{10.02, 6.99, -0.427}, Pose2{10.3, 6.86, -0.427}, Pose2{10.58, 6.73, -0.427},
        Pose2{10.86, 6.61, -0.427}, Pose2{11.1, 6.5, -0.6}, Pose2{11.31, 6.29, -0.785},
        // the newer visit
        Pose2{11.1, 6.5, 2.618}, Pose2{11.1, 6.5, 2.897}, Pose2{10.79, 6.5, 3.142},
        Pose2{10.48, 6.5, 3.142}, Pose2{10.18, 6.5, 3.142}}) {
    Keyframe key;
    key.world_from_robot = pose;
    key.points_in_robot = orient(office.hits(pose, 0.01, &random), {0, 0}, {});
    keys.push_back(std::move(key));
  }
  LoopCandidate candidate;
  candidate.from = 4;
  candidate.to = 13;
  candidate.world_from_old = keys[4].world_from_robot;
  candidate.world_from_newest = keys[13].world_from_robot;
  candidate.place = join_points(keys, 0, 8, {});
  candidate.seen = join_points(keys, 9, 13, keys[13].world_from_robot.inverse());
  candidate.covariance = diagonal_covariance(0.18, 0.037);
  const LoopCloser closer({}, CorrelativeMatcher(), SurfelMatcher());
  const auto pushed = closer.verify(candidate);
  EXPECT_TRUE(!pushed || pushed->shift_m > 0.15) << "nobody says what the older visit could see";
  candidate.place_keys = {keys.begin(), keys.begin() + 9};
  const auto loop = closer.verify(candidate);
  ASSERT_TRUE(loop);
  EXPECT_LT(loop->shift_m, 0.05);
}

}  // namespace
}  // namespace marco::slam
