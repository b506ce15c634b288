#include "slam/map/scan_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

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

}  // namespace
}  // namespace marco::slam
