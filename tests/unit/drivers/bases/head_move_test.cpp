#include "teleop/head_move.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/pose2.hpp"

namespace marco::teleop {
namespace {

using HeadNext = HeadMove::Next;

// A pan-tilt that says ten times a second where it looks.
class Head {
 public:
  double pan_deg = 0.0, tilt_deg = 0.0;
  double pan_limit_deg = 180.0;

  // Toward the order, at this rate in degrees per second, from `begins_s` on.
  // @returns what the move says first that is not `wait`, and when.
  std::pair<HeadNext, double> go(double to_pan_deg,
                                 double to_tilt_deg,
                                 double rate,
                                 double begins_s) {
    PanTiltCommand order;
    order.pan_rad = deg_to_rad(to_pan_deg);
    order.tilt_rad = deg_to_rad(to_tilt_deg);
    HeadMove move(order);
    const double reach_deg = std::min(to_pan_deg, pan_limit_deg);
    for (double at_s = 0.0; at_s < 60.0; at_s += 0.1) {
      const auto step = [&](double& at_deg, double to_deg) {
        at_deg += std::clamp(to_deg - at_deg, -0.1 * rate, 0.1 * rate);
      };
      if (at_s >= begins_s) {
        step(pan_deg, reach_deg);
        step(tilt_deg, to_tilt_deg);
      }
      PanTiltState state;
      state.utime = Utime::from_seconds(1000.0 + at_s);
      // Whole units of 1.45 degrees.
      state.pan_rad = deg_to_rad(1.45 * std::round(pan_deg / 1.45));
      state.tilt_rad = deg_to_rad(tilt_deg);
      if (const HeadNext next = move.on_state(state); next != HeadNext::wait) return {next, at_s};
    }
    return {HeadNext::wait, 60.0};
  }
};

TEST(HeadMove, IsThereWhenItStandsAtTheOrderedAngles) {
  Head head;
  const auto [next, at_s] = head.go(60.0, -10.0, 20.0, 0.3);
  EXPECT_EQ(next, HeadNext::there);
  EXPECT_NEAR(at_s, 0.3 + 3.0 + 0.3, 0.25);
  EXPECT_EQ(head.go(60.0, -10.0, 20.0, 0.3).first, HeadNext::there) << "it stands there already";
}

TEST(HeadMove, OfASlowHeadIsWaitedFor) {
  Head head;
  EXPECT_EQ(head.go(30.0, 0.0, 1.0, 1.0).first, HeadNext::there);
}

TEST(HeadMove, HasEndedWhereTheHeadReachesNoFarther) {
  Head head;
  head.pan_limit_deg = 90.0;
  const auto [next, at_s] = head.go(120.0, 0.0, 30.0, 0.2);
  EXPECT_EQ(next, HeadNext::ended);
  EXPECT_NEAR(at_s, 3.2 + 1.5, 0.3);
}

TEST(HeadMove, HasEndedWhenTheHeadDoesNotMove) {
  Head head;
  const auto [next, at_s] = head.go(30.0, 0.0, 0.0, 0.0);
  EXPECT_EQ(next, HeadNext::ended);
  EXPECT_NEAR(at_s, 3.0, 0.2);
}

}  // namespace
}  // namespace marco::teleop
