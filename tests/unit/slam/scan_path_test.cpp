#include "slam/map/scan_path.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "common/input/deskew.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::testing::HasSubstr;

constexpr double kWayM = 10.0, kTurnRad = 0.1;

// At constant speed and turn rate, `part` of the way.
Pose2 on_arc(double part) { return Velocity2{kWayM, 0.0, kTurnRad}.after(part); }

// Between two keyframes nothing is matched, and odometry goes straight where the robot turns.
struct BlindStretch {
  BlindStretch() {
    add_keyframe(0.0, Pose2{}, false);
    for (int i = 1; i < 20; ++i) add(0.05 * i, true);
    add_keyframe(1.0, Pose2{kWayM, 0, 0}, true);
    for (int i = 1; i < 5; ++i) add(1.0 + 0.05 * i, true);
  }
  static Utime stamp(double part) { return Utime::from_seconds(1.0 + part); }
  void add(double part, bool predicted) {
    path.add_scan({stamp(part), Pose2{part * kWayM, 0, 0}}, std::nullopt, predicted, keys);
  }
  void add_keyframe(double part, const Pose2& at, bool predicted) {
    path.add_keyframe(stamp(part), static_cast<int>(keys.size()));
    keys.push_back({stamp(part), {}, {0, 0}, 0.0, at, part * kWayM});
    add(part, predicted);
  }
  void move_to(const std::vector<Pose2>& world_from_keys) {
    path.spread_moves(keys, world_from_keys);
    for (std::size_t i = 0; i < keys.size(); ++i) keys[i].world_from_robot = world_from_keys[i];
  }

  std::vector<Keyframe> keys;
  ScanPath path;
};

TEST(ScanPath, WhatWasPredictedBetweenTwoKeyframesBendsWithThem) {
  BlindStretch stretch;
  const Pose2 moved{3.0, -2.0, 0.7};  // the whole map, as well
  stretch.move_to({moved, moved * on_arc(1.0)});
  const Trajectory scans = stretch.path.scans(stretch.keys);
  for (int i = 0; i <= 20; ++i) {
    EXPECT_THAT(scans[static_cast<std::size_t>(i)].world_from_robot,
                IsNear(moved * on_arc(0.05 * i), 0.01, 1e-3))
        << i;
  }
  // What follows moves with the second keyframe.
  EXPECT_THAT(scans.back().world_from_robot,
              IsNear(moved * on_arc(1.0) * Pose2{2, 0, 0}, 1e-9, 1e-9));
}

TEST(ScanPath, WhatWasMatchedStaysWithItsKeyframe) {
  BlindStretch stretch;
  ScanPathState state = stretch.path.state();
  for (ScanPose& scan : state.scans) scan.predicted = false;
  stretch.path.restore(state);
  stretch.move_to({Pose2{}, on_arc(1.0)});
  const Trajectory scans = stretch.path.scans(stretch.keys);
  for (int i = 0; i < 20; ++i) {
    EXPECT_THAT(scans[static_cast<std::size_t>(i)].world_from_robot,
                IsNear(Pose2{0.05 * i * kWayM, 0, 0}, 1e-9, 1e-9));
  }
}

TEST(ScanPath, TwoMovesAreAsGoodAsOne) {
  BlindStretch once, twice;
  once.move_to({Pose2{}, on_arc(1.0)});
  twice.move_to({Pose2{}, Pose2{kWayM, 0.4, 0.05}});
  twice.move_to({Pose2{}, on_arc(1.0)});
  const Trajectory a = once.path.scans(once.keys), b = twice.path.scans(twice.keys);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_THAT(b[i].world_from_robot, IsNear(a[i].world_from_robot, 0.01, 1e-3)) << i;
  }
}

// Of keyframes that lie at (4, 0), (8, 0) ..., with scans each second.
class ScanPathTest : public ::testing::Test {
 protected:
  void restart() {
    keys_.clear();
    path_ = {};
    scans_ = 0;
  }
  void add_keyframe() {
    const double x_m = 4.0 * static_cast<double>(keys_.size() + 1);
    path_.add_keyframe(now(), static_cast<int>(keys_.size()));
    keys_.push_back({now(), {}, {0, 0}, 0.0, {x_m, 0, 0}, x_m});
  }
  Utime now() const { return Utime::from_seconds(scans_ + 1.0); }
  void add(const Pose2& at,
           const std::optional<Pose2>& odom = std::nullopt,
           bool predicted = false) {
    path_.add_scan({now(), at}, odom, predicted, keys_);
    ++scans_;
  }
  void predict(const Pose2& at) { add(at, std::nullopt, true); }
  std::vector<Pose2> found() const {
    std::vector<Pose2> poses;
    for (const StampedPose2& scan : path_.scans(keys_)) poses.push_back(scan.world_from_robot);
    return poses;
  }
  std::vector<double> found_x_m() const {
    std::vector<double> x_m;
    for (const Pose2& pose : found()) x_m.push_back(pose.x_m);
    return x_m;
  }

  std::vector<Keyframe> keys_;
  ScanPath path_;
  int scans_ = 0;
};

constexpr double kNear = 1e-9;  // sums of a few doubles

TEST_F(ScanPathTest, AScanMovesWithTheKeyframeThatWasNewestAndStaysWithoutOne) {
  add({1, 0, 0});
  add_keyframe();
  add({5, 0, 0});
  keys_[0].world_from_robot = {4, 2, 0};
  EXPECT_THAT(found()[0], IsNear(Pose2{1, 0, 0}, kNear, kNear));
  EXPECT_THAT(found()[1], IsNear(Pose2{5, 2, 0}, kNear, kNear));
}

TEST_F(ScanPathTest, ScansOfOneStopLieWhereTheLastOfThemDoes) {
  const Pose2 odom{7, -3, 2};
  add_keyframe();
  add({4.0, 0, 0}, Pose2{6.5, -3, 2});
  add({4.5, 0, 0}, odom);
  add({4.52, 0.01, 0.01}, odom);
  add({4.51, -0.02, -0.01}, odom);
  add({5.0, 0, 0}, Pose2{7.5, -3, 2});
  const Pose2 last{4.51, -0.02, -0.01};
  for (const std::size_t i : {1U, 2U, 3U}) EXPECT_THAT(found()[i], IsNear(last, kNear, kNear));
  EXPECT_THAT(found()[0], IsNear(Pose2{4, 0, 0}, kNear, kNear));
  EXPECT_THAT(found()[4], IsNear(Pose2{5, 0, 0}, kNear, kNear));
}

// Pushed and turned with its wheels still, or without odometry that could tell, it makes no stop.
TEST_F(ScanPathTest, ARobotThatIsMovedWhileItsWheelsStandMakesNoStop) {
  const Pose2 odom{7, -3, 2};
  const std::vector<Pose2> pushed{{4, 0, 0}, {4, 0.1, 0}, {4, 0.1, 0.1}};
  add_keyframe();
  for (const Pose2& place : pushed) add(place, odom);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_THAT(found()[i], IsNear(pushed[i], kNear, kNear));
  add({4, 0.11, 0.1});
  EXPECT_THAT(found()[2], IsNear(pushed[2], kNear, kNear)) << "its odometry is silent";
}

// A slow push is one as well: what counts is where the stop began, also after a restart.
TEST_F(ScanPathTest, ASlowPushIsNoStopHoweverOftenTheMapperIsRestarted) {
  const Pose2 odom{7, -3, 2};
  for (const bool restarts : {false, true}) {
    restart();
    add({-1, 0, 0}, Pose2{6, -3, 2});
    for (int i = 0; i < 9; ++i) {
      if (restarts) path_.restore(ScanPathState(path_.state()));
      add({0.03 * i, 0, 0}, odom);
    }
    // By twos: 3 cm are within a stop, 6 cm are not.
    for (int i = 0; i < 9; ++i) {
      EXPECT_NEAR(found_x_m()[static_cast<std::size_t>(i) + 1], 0.03 * i, 0.031) << restarts;
    }
    EXPECT_EQ(path_.state().scans[1].stands, false);
    EXPECT_EQ(path_.state().scans[2].stands, true);
    EXPECT_EQ(path_.state().scans[3].stands, false);
  }
}

TEST_F(ScanPathTest, ACorrectionIsSharedByTheWayThatWasPredicted) {
  add_keyframe();
  add({4, 0, 0});
  for (const double x_m : {5.0, 5.0, 7.0}) predict({x_m, 0, 0});
  path_.spread_correction({4, 0, 0}, {8, 0, 0}, {8.8, 0.4, 0}, keys_);
  const Pose2 shared[] = {{4, 0, 0}, {5.2, 0.1, 0}, {5.2, 0.1, 0}, {7.6, 0.3, 0}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_THAT(found()[i], IsNear(shared[i], kNear, kNear)) << i;
}

TEST_F(ScanPathTest, ACorrectedHeadingBendsTheWayAndTurnsOnTheSpotTakeTheirShare) {
  add_keyframe();
  add({4, 0, 0});
  for (int i = 1; i < 10; ++i) predict(Pose2{4, 0, 0} * Pose2{1.0 * i, 0, 0});
  path_.spread_correction({4, 0, 0}, {14, 0, 0}, Pose2{4, 0, 0} * on_arc(1.0), keys_);
  for (int i = 0; i < 10; ++i) {
    EXPECT_THAT(found()[static_cast<std::size_t>(i)],
                IsNear(Pose2{4, 0, 0} * on_arc(0.1 * i), 0.01, 1e-3))
        << i;
  }
  restart();
  add({0, 0, 0});
  for (const double turned_rad : {1.0, 2.0, 3.0}) predict({0, 0, turned_rad});
  path_.spread_correction({}, {0, 0, -2.2}, {0, 0, -2.0}, keys_);  // the last turn passes pi
  for (std::size_t i = 0; i < 4; ++i) {
    const double turned_rad = 1.0 * static_cast<double>(i);
    EXPECT_THAT(
        found()[i],
        IsNear(Pose2{0, 0, turned_rad * (1.0 + 0.2 / (2.0 * std::numbers::pi - 2.2))}, kNear, 1e-6))
        << i;
  }
}

TEST_F(ScanPathTest, NothingIsSharedByARobotThatStoodOrWasNeverMatched) {
  predict({1, 0, 0});
  predict({2, 0, 0});
  path_.spread_correction({}, {3, 0, 0}, {3, 1, 0}, keys_);
  EXPECT_THAT(found()[1], IsNear(Pose2{2, 0, 0}, 0.0, 0.0)) << "never matched";
  restart();
  add({1, 0, 0});
  for (int i = 0; i < 3; ++i) predict({1, 0, 0});
  path_.spread_correction({1, 0, 0}, {1, 0, 0}, {1, 0.5, 0}, keys_);
  EXPECT_THAT(found()[3], IsNear(Pose2{1, 0, 0}, 0.0, 0.0)) << "stood";
  add({2, 0, 0});
  path_.spread_correction({2, 0, 0}, {3, 0, 0}, {3, 1, 0}, keys_);
  EXPECT_THAT(found()[4], IsNear(Pose2{2, 0, 0}, 0.0, 0.0)) << "none was predicted";
}

// What carries a robot on knows that a millimetre of its last match was noise.
TEST_F(ScanPathTest, AStopKeepsItsPlaceThoughItIsCarriedOnFromBesideItsMatch) {
  add_keyframe();
  add({4, 0, 0});
  for (int i = 0; i < 3; ++i) predict({4.001, 0, 0});
  path_.spread_correction({4.001, 0, 0}, {4.001, 0, 0}, {4.08, 0, 0}, keys_);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_THAT(found()[i], IsNear(Pose2{4, 0, 0}, 0.0011, kNear)) << i;
}

TEST_F(ScanPathTest, OfAShortPathScansFarEnoughApartAreKeptAndTheFirstOfEachKeyframe) {
  path_.keep_short(0.5, 0);
  for (const double x_m : {0.0, 0.3, 0.6, 0.9, 1.2}) add({x_m, 0, 0}, Pose2{});
  EXPECT_EQ(found_x_m(), (std::vector<double>{0.0, 0.6, 1.2}));
  add({1.2, 0, -0.4});
  add({1.2, 0, -0.6});
  EXPECT_EQ(found().size(), 4U) << "turned by more than half a radian";
  add_keyframe();
  add({1.2, 0, -0.6});
  EXPECT_EQ(found().size(), 5U) << "the first of a keyframe";
  EXPECT_THAT(complaint([&] { path_.keep_short(-0.1, 0); }), HasSubstr("negative distance"));
}

// It stood, by odometry; but the scan before may be missing, and would be moved.
TEST_F(ScanPathTest, OfAShortPathTheScansBeforeItWasShortAreKeptAndNoStopMovesThem) {
  path_.keep_short(0.0, 3);
  for (int i = 0; i < 3; ++i) add({0.01 * i, 0, 0}, Pose2{});
  EXPECT_EQ(found_x_m(), (std::vector<double>{0.0, 0.01, 0.02}));
  path_.keep_short(0.5, 3);
  for (int i = 3; i < 9; ++i) add({0.12 * i, 0, 0}, Pose2{});
  EXPECT_EQ(found_x_m(), (std::vector<double>{0.0, 0.01, 0.02, 0.36, 0.96}));
}

TEST_F(ScanPathTest, AMergedKeyframesScansStayWhereTheyAre) {
  for (int i = 0; i < 3; ++i) {
    add_keyframe();
    for (int scan = 0; scan < 3; ++scan) add({4.0 * i + scan, 1, 0.2});
  }
  const std::vector<Pose2> before = found();
  const Trajectory keyframes = path_.keyframes(keys_);
  const MergedKeyframe merged{0, between(keys_[0].world_from_robot, keys_[1].world_from_robot), {}};
  path_.reattach_to_keyframe(1, merged, keys_);
  keys_.erase(keys_.begin() + 1);
  ASSERT_EQ(found().size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_THAT(found()[i], IsNear(before[i], kNear, kNear)) << i;
  }
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    EXPECT_THAT(path_.keyframes(keys_)[i].world_from_robot,
                IsNear(keyframes[i].world_from_robot, kNear, kNear))
        << i;
  }
  // They move with what they hang on now.
  keys_[0].world_from_robot = keys_[0].world_from_robot * Pose2{0, 1, 0};
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(found()[i].y_m, i < 6 ? 2.0 : 1.0, kNear) << i;
  }
}

TEST_F(ScanPathTest, OfAShortPathAMergedKeyframesScansGoBesideThoseBeforeItWasShort) {
  for (int i = 0; i < 3; ++i) {
    add_keyframe();
    for (int scan = 0; scan < 3; ++scan) add({4.0 * i + scan, 0, 0});
    if (i == 1) path_.keep_short(0.5, 4);
  }
  path_.reattach_to_keyframe(1, {0, {4, 0, 0}, {}}, keys_);
  keys_.erase(keys_.begin() + 1);
  EXPECT_EQ(found_x_m(), (std::vector<double>{0, 1, 2, 4, 8, 9, 10}));
}

// Many keyframes have become one with two that are left.
TEST_F(ScanPathTest, OfAShortPathTheOlderHalfOfTheTrailIsThinnedWhereItIsLongForItsMap) {
  const auto trail_us = [&](int poses) {
    restart();
    ScanPathState state;
    for (int i = 0; i < poses; ++i) state.keyframe_poses.push_back({Utime::from_us(i), i % 2, {}});
    keys_.resize(2);
    keys_[0].utime = Utime::from_us(2);
    keys_[1].utime = Utime::from_us(poses - 1);
    path_.restore(state);
    path_.shorten(keys_);
    EXPECT_EQ(path_.keyframes(keys_).size(), state.keyframe_poses.size()) << "of a whole one none";
    path_.keep_short(0.5, 0);
    path_.shorten(keys_);
    std::vector<int64_t> us;
    for (const StampedPose2& pose : path_.keyframes(keys_)) us.push_back(pose.utime.us);
    return us;
  };
  EXPECT_EQ(trail_us(8).size(), 8U);
  // Pose 2 is a keyframe's own; of 0, 1, 3, 4 and 5 every second one is dropped.
  EXPECT_EQ(trail_us(12), (std::vector<int64_t>{1, 2, 4, 6, 7, 8, 9, 10, 11}));
}

TEST_F(ScanPathTest, AnotherSessionFollowsWithItsKeyframes) {
  add_keyframe();
  add({5, 0, 0});
  ScanPath session;
  session.add_scan({Utime::from_us(7), {0.5, 0, 0}}, std::nullopt, false, {});
  std::vector<Keyframe> keys{keys_[0]};
  keys[0].world_from_robot = {1, 0, 0};
  session.add_keyframe(Utime::from_us(8), 0);
  session.add_scan({Utime::from_us(8), {2, 0, 0}}, std::nullopt, false, keys);
  const Pose2 moved{10, 10, 0};
  path_.append(session.state(), 1, moved);
  keys_.push_back(keys[0]);
  keys_[1].world_from_robot = moved * keys[0].world_from_robot;
  EXPECT_EQ(found_x_m(), (std::vector<double>{5.0, 10.5, 12.0}));
  const Trajectory keyframes = path_.keyframes(keys_);
  ASSERT_EQ(keyframes.size(), 2U);
  EXPECT_THAT(keyframes[1].world_from_robot, IsNear(Pose2{11, 10, 0}, kNear, kNear));
  EXPECT_EQ(keyframes[1].utime.us, 8);
}

TEST_F(ScanPathTest, ImpossibleOnesAreRefusedAndSaidSo) {
  add({1, 0, 0});
  for (int i = 0; i < 2; ++i) {
    add_keyframe();
    add({4.0 * i + 4.0, 0, 0});
  }
  const auto said = [&](const auto& spoil) {
    ScanPathState state = path_.state();
    KeyframeSet set{keys_, 1};
    spoil(state);
    return complaint([&] { check(state, set); });
  };
  const ScanPose beyond{{}, 2, {}}, before{{}, -2, {}}, none{{}, -1, {}}, far{{}, 0, {0, 2e6, 0}};
  EXPECT_EQ(said([](ScanPathState&) {}), "");
  EXPECT_EQ(said([](ScanPathState& path) {
              path.keyframe_poses.push_back({{}, 0, {}});
            }),
            "")
      << "that of the one that was merged";
  const auto relative = HasSubstr("relative to no keyframe");
  EXPECT_THAT(said([&](ScanPathState& path) { path.scans[1] = beyond; }), relative);
  EXPECT_THAT(said([&](ScanPathState& path) { path.scans[1] = before; }), relative);
  EXPECT_THAT(said([&](ScanPathState& path) { path.keyframe_poses[1] = beyond; }), relative);
  EXPECT_THAT(said([&](ScanPathState& path) { path.keyframe_poses[1] = none; }), relative);
  EXPECT_THAT(said([&](ScanPathState& path) { path.keyframe_poses[1] = far; }),
              HasSubstr("farther away"));
  EXPECT_THAT(said([](ScanPathState& path) { path.keyframe_poses.resize(4); }),
              HasSubstr("more keyframe poses"));
}

}  // namespace
}  // namespace marco::slam
