// A base stops no later than its guard foresees: its delay and braking are not below what its
// emulator needs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "any_base.hpp"

namespace marco::drivers {
namespace {

template <class Base>
class StoppingWay : public ::testing::Test {};
TYPED_TEST_SUITE(StoppingWay, testing::Bases);

/// Drives, and orders a stop at some moment. @returns how far beyond the foreseen way it went, from
/// where it was known to be [m or rad], < 0: it stopped before that.
template <class Base>
double beyond_foreseen(double v, double w, double moment_s) {
  Base base;
  for (double t_s = 0.0; t_s < 1.5; t_s += 0.1) {
    base.velocity(v, w);
    base.bench.run(0.1);
  }
  base.bench.run(moment_s);
  const Pose2 known = base.driver.odom_from_robot();
  const OdometrySample was = base.odometry.back();
  base.velocity(0.0, 0.0);
  base.bench.run(2.0);
  const Pose2 way = between(known, base.driver.odom_from_robot());
  const GuardOptions& options = base.driver.guard().options();
  const BaseDynamics dynamics = base.driver.dynamics();
  const double sure = std::min(1.0, options.braking_m_per_s2 / dynamics.braking_m_per_s2);
  const double speed = std::abs(v != 0.0 ? was.velocity_m_per_s : was.yaw_rate_rad_per_s);
  const double braking =
      sure * (v != 0.0 ? dynamics.braking_m_per_s2 : dynamics.turn_braking_rad_per_s2);
  EXPECT_GT(speed, 0.05);
  return std::abs(v != 0.0 ? way.x_m : way.theta_rad) -
         (options.delay_s * speed + 0.5 * speed * speed / braking);
}

TYPED_TEST(StoppingWay, IsForeseen) {
  for (const double moment_s : {0.0, 0.06, 0.13, 0.21, 0.33}) {
    EXPECT_LT(beyond_foreseen<TypeParam>(0.25, 0.0, moment_s), 0.0) << moment_s;
    EXPECT_LT(beyond_foreseen<TypeParam>(0.0, 0.6, moment_s), 0.0) << moment_s;
  }
}

}  // namespace
}  // namespace marco::drivers
