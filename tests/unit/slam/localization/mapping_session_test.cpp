// Sessions of one building and of two, and what a refused order leaves alone.
#include "slam/session/mapping_session.hpp"
#include "slam/session/merge_maps.hpp"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recorded_drive.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::FlatWorld;
using ::marco::testing::IsNear;
using ::testing::HasSubstr;

FlatWorld one_building() {
  FlatWorld world = testing::small_room();
  world.add_chain({{-4, -3}, {-4, -6}, {12, -6}, {12, 3}, {4, 3}});
  world.add_box(8.0, -2.0, 8.5, -0.6);
  world.add_box(10.5, 0.4, 11.2, 1.0);
  world.add_box(6.0, -5.2, 6.9, -4.9);
  return world;
}

FlatWorld another_building() {
  FlatWorld world;
  world.add_chain({{-7, -5}, {7, -5}, {7, 2}, {9, 2}, {9, 3}, {7, 3}, {7, 5}, {-7, 5}, {-7, -5}});
  world.add_box(-1.0, -1.0, 0.6, 0.4);
  world.add_box(4.5, -3.0, 5.2, 2.0);
  world.add_box(-6.0, 2.0, -4.5, 3.5);
  return world;
}

// A round of 4.2 m a side with round corners takes 160 steps.
std::vector<Pose2> round_from(const Pose2& start, int steps) {
  std::vector<Pose2> path{start};
  for (int i = 1; i < steps; ++i) {
    path.push_back(path.back() * Pose2{0.1, 0, deg_to_rad(i % 40 >= 32 ? 11.25 : 0.0)});
  }
  return path;
}

class MappingSessionTest : public ::testing::Test {
 protected:
  void drive(const FlatWorld& world, const std::vector<Pose2>& path) {
    ++drives_;
    const auto inputs = recorded_drive(world, path, static_cast<uint32_t>(2 + drives_),
                                       int64_t{1'000'000'000} * drives_);
    for (const SlamInput& input : inputs) session_.process(input);
  }
  SavedMap map_of(const FlatWorld& world, const std::vector<Pose2>& path) {
    session_.reset();
    drive(world, path);
    session_.finish();
    return session_.saved("");
  }
  const std::vector<Pose2> here_ = round_from({6.3, -3.6, 0.0}, 130);
  const std::vector<Pose2> here_too_ = round_from({10.0, -3.0, 1.5707963}, 60);
  const std::vector<Pose2> there_ = round_from({-2.0, -2.5, 0.0}, 130);
  const std::vector<Pose2> there_too_ = round_from({1.8, 0.5, 1.5707963}, 60);
  MappingSession session_{{}, {}};
  int drives_ = 0;
};

TEST_F(MappingSessionTest, SessionsOfTwoBuildingsMakeTwoMaps) {
  drive(one_building(), here_);
  session_.start_session();
  drive(another_building(), there_);
  session_.start_session();
  drive(one_building(), here_too_);  // begins elsewhere than where the first one ended
  session_.start_session();
  drive(another_building(), there_too_);
  session_.finish();
  ASSERT_EQ(session_.apart().size(), 1U);
  EXPECT_EQ(session_.apart()[0].sessions, (std::vector<int>{2, 4}));
  EXPECT_EQ(session_.saved("").session_starts, (std::vector<int64_t>{0, 130}));
  EXPECT_EQ(session_.slam().trajectory().size(), 190U);
  const auto poses = session_.trajectory();
  ASSERT_EQ(poses.size(), 380U);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const bool first = i < 130, third = i >= 260 && i < 320;
    ASSERT_EQ(poses[i].has_value(), first || third) << i;
    if (!poses[i]) continue;
    const Pose2& true_pose = first ? here_[i] : here_too_[i - 260];
    // Noise of 1 cm over hundreds of beams, and the map's own error.
    EXPECT_THAT(*poses[i], IsNear(between(here_[0], true_pose), 0.03, 0.01)) << i;
  }
  Slam other;
  other.restore(session_.apart()[0].map.slam);
  const Trajectory there = other.trajectory();
  ASSERT_EQ(there.size(), 190U);
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_THAT(there[130 + i].world_from_robot,
                IsNear(between(there_[0], there_too_[i]), 0.03, 0.01));
  }
}

TEST_F(MappingSessionTest, ExtendingASessionInAStrangeBuildingIsSetApartAndTheNextOneIsFound) {
  const SavedMap map = map_of(one_building(), here_);
  session_.extend(map);
  drive(another_building(), there_);
  EXPECT_FALSE(session_.joined());
  EXPECT_TRUE(session_.findings().empty());
  session_.start_session();
  drive(one_building(), here_too_);
  session_.finish();
  EXPECT_EQ(session_.findings().size(), 1U);
  ASSERT_EQ(session_.apart().size(), 1U);
  EXPECT_EQ(session_.apart()[0].sessions, (std::vector<int>{1}));
  const auto poses = session_.trajectory();
  ASSERT_EQ(poses.size(), 190U);
  EXPECT_FALSE(poses[129].has_value());
  EXPECT_THAT(*poses[130], IsNear(between(here_[0], here_too_[0]), 0.03, 0.01));
}

// Where it looks seldom after so long a way.
TEST_F(MappingSessionTest, ASessionThatComesIntoTheMapAfterALongWayIsFound) {
  const SavedMap map = map_of(one_building(), here_);
  std::vector<Keyframe> keys =
      map_of(another_building(), round_from({-2.0, -2.5, 0.0}, 300)).slam.keyframes.keys;
  const double way_m = keys.back().path_m;
  ASSERT_GT(way_m, 25.0);
  for (Keyframe key : map_of(one_building(), here_too_).slam.keyframes.keys) {
    key.path_m += way_m + 9.0;  // beyond what is looked at together
    keys.push_back(key);
  }
  FrozenMap frozen(map.slam.keyframes.keys, {}, {});
  const auto found = find_session(frozen, keys, {});
  ASSERT_TRUE(found.has_value());
  EXPECT_THAT(found->place.map_from_robot,
              IsNear(between(here_[0], here_too_[0]) *
                         keys[static_cast<std::size_t>(found->newest_key)].world_from_robot,
                     0.05, 0.02));
}

TEST_F(MappingSessionTest, WhatIsRefusedChangesNothing) {
  drive(one_building(), here_);
  const auto before = session_.trajectory();
  const std::size_t keys = session_.keys().size();
  ASSERT_GT(keys, 20U);
  const auto expect_refused = [&](const char* why, const std::function<void()>& act) {
    EXPECT_THAT(complaint(act), HasSubstr(why));
    ASSERT_EQ(session_.keys().size(), keys) << why;
    ASSERT_EQ(session_.trajectory().size(), before.size());
    EXPECT_EQ(session_.trajectory().back()->vector(), before.back()->vector());
  };
  expect_refused("farther away", [&] { session_.set_pose({1e9, 0, 0}); });
  expect_refused("farther away", [&] { session_.set_pose({0, std::nan(""), 0}); });
  expect_refused("no point", [&] { session_.localizer_in({}); });
  expect_refused("no point", [&] { session_.extend({}); });
  expect_refused("no session", [&] { session_.restore({}); });
  SavedMap far = session_.saved("");
  far.slam.estimate.world_from_robot.x_m = 1e12;
  expect_refused("farther away", [&] { session_.restore(far); });
}

// Of a place that is unsure along the map's x, whatever way the robot looks there.
TEST_F(MappingSessionTest, TheTieOfTwoSessionsIsAsSureAsThePlaceSeenFromTheRobot) {
  const SavedMap map = map_of(one_building(), here_);
  const FrozenMap frozen(map.slam.keyframes.keys, {}, {});
  FoundPlace place;
  place.nearest_key = 3;
  place.map_from_robot = {2.0, 1.0, 0.5};
  constexpr double kAlong = 1e-2, kAcross = 1e-4;
  place.covariance = Eigen::Vector3d(kAlong, kAcross, 1e-3).asDiagonal();
  const PoseGraphEdge edge = edge_to(frozen, place, 7);
  EXPECT_EQ(edge.from, 3);
  EXPECT_EQ(edge.to, 7);
  EXPECT_THAT(map.slam.keyframes.keys[3].world_from_robot * edge.from_from_to,
              IsNear(place.map_from_robot, 1e-9, 1e-9));
  // The robot looks to the left of x: what is unsure lies ahead and to its right.
  const double c = std::cos(0.5), s = std::sin(0.5);
  const Eigen::Matrix3d seen = edge.information.inverse();
  constexpr double kFloor = 1e-9;  // of information_of()
  EXPECT_NEAR(seen(0, 0), kAlong * c * c + kAcross * s * s + kFloor, 1e-12);
  EXPECT_NEAR(seen(1, 1), kAlong * s * s + kAcross * c * c + kFloor, 1e-12);
  EXPECT_NEAR(seen(0, 1), (kAcross - kAlong) * s * c, 1e-12);
  EXPECT_NEAR(seen(2, 2), 1e-3 + kFloor, 1e-12);
}

TEST_F(MappingSessionTest, MergedMapsKeepTheirSessionsAndAreOptimized) {
  const SavedMap first = map_of(one_building(), here_);
  const SavedMap second = map_of(one_building(), here_too_);
  std::vector<std::size_t> not_found;
  const SavedMap merged = merge_maps({first, second}, {}, {}, not_found);
  EXPECT_TRUE(not_found.empty());
  EXPECT_EQ(merged.session_starts, (std::vector<int64_t>{0, 130}));
  // A keyframe that lies where its edges deny it.
  SavedMap bent = first;
  bent.slam.keyframes.keys[5].world_from_robot.x_m += 0.2;
  const SavedMap straight = merge_maps({bent}, {}, {}, not_found);
  EXPECT_THAT(straight.slam.keyframes.keys[5].world_from_robot,
              IsNear(first.slam.keyframes.keys[5].world_from_robot, 0.02, 0.01));
}

// Hours later, with odometry that counts from zero again.
TEST_F(MappingSessionTest, ResumedWhereTheRobotStoodTheMapGoesOnAtOnce) {
  const SavedMap map = map_of(one_building(), here_);
  session_.resume(map);
  EXPECT_NE(session_.waiting_map(), nullptr);
  const std::vector<Pose2> on = round_from(here_.back(), 60);
  drive(one_building(), on);
  EXPECT_EQ(session_.waiting_map(), nullptr);
  ASSERT_TRUE(session_.joined());
  EXPECT_EQ(session_.findings().front().path_m, 0.0);
  EXPECT_THAT(session_.slam().trajectory().back().world_from_robot,
              IsNear(between(here_[0], on.back()), 0.03, 0.01));
}

TEST_F(MappingSessionTest, ResumedElsewhereItIsLostUntilItIsFound) {
  const SavedMap map = map_of(one_building(), here_);
  session_.resume(map);
  std::size_t lost = 0;
  for (const SlamInput& input : recorded_drive(one_building(), here_too_, 7, 9'000'000'000)) {
    const SlamUpdate update = session_.process(input);
    if (session_.waiting_map() == nullptr) continue;
    ++lost;
    ASSERT_EQ(update.status, SlamUpdate::Status::lost);
    ASSERT_EQ(session_.waiting_map()->slam.keyframes.keys.size(), map.slam.keyframes.keys.size());
  }
  EXPECT_GT(lost, 0U);
  ASSERT_TRUE(session_.joined());
  EXPECT_THAT(session_.slam().trajectory().back().world_from_robot,
              IsNear(between(here_[0], here_too_.back()), 0.03, 0.01));
}

TEST_F(MappingSessionTest, ResumedInAStrangeBuildingItBeginsANewMapAndKeepsTheOther) {
  const SavedMap map = map_of(one_building(), here_);
  session_.resume(map);
  drive(another_building(), there_);
  EXPECT_FALSE(session_.give_up_after(50.0).has_value());
  const auto old = session_.give_up_after(10.0);
  ASSERT_TRUE(old.has_value());
  EXPECT_EQ(encode_saved_map(*old), encode_saved_map(map));
  EXPECT_EQ(session_.mode(), MappingSession::Mode::mapping);
  EXPECT_EQ(session_.slam().trajectory().size(), there_.size());
  EXPECT_FALSE(session_.give_up_after(0.0).has_value());
}

}  // namespace
}  // namespace marco::slam
