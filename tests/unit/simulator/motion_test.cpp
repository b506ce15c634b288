#include <gmock/gmock.h>

#include <cmath>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "simulator/batch_simulation.hpp"
#include "simulator/tour.hpp"
#include "tests/support/matchers.hpp"

namespace marco::sim {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;

TourStep go(double x_m, double y_m) {
  TourStep step;
  step.to_m = {x_m, y_m};
  return step;
}

Tour two_legs() {
  Tour tour;
  tour.steps = {go(2, 0), go(2, 1.5)};
  return tour;
}

TEST(MotionPlan, EndsWhereItWasSentAndNeverBreaksItsLimits) {
  const RobotOptions robot;
  const MotionPlan plan(two_legs(), robot, 37.5);
  EXPECT_THAT(plan.at(plan.duration_s() + 1).world_from_robot,
              IsNear(Pose2{2, 1.5, deg_to_rad(90)}, 1e-9, 1e-9));
  constexpr double kStepS = 1e-3;
  double speed = 0.0;
  for (double t = 0; t < plan.duration_s(); t += kStepS) {
    const Pose2 moved = between(plan.at(t).world_from_robot, plan.at(t + kStepS).world_from_robot);
    const double speed_now = moved.translation_m().norm() / kStepS;
    ASSERT_LE(speed_now, robot.speed_m_per_s * 1.001);
    ASSERT_LE(std::abs(moved.theta_rad) / kStepS, deg_to_rad(robot.turn_rate_deg_per_s) * 1.001);
    // Where it starts or stops within a step the mean speed jumps by up to half of a step's more.
    ASSERT_LE(std::abs(speed_now - speed) / kStepS, robot.acceleration_m_per_s2 * 1.01 + 1e-6);
    speed = speed_now;
  }
}

TEST(MotionPlan, ASweepHasItsRowsAtTheScanRate) {
  Tour tour;
  TourStep sweep;
  sweep.kind = "sweep";
  sweep.tilt_from_deg = -20;
  sweep.tilt_to_deg = 40;
  sweep.rows = 60;
  tour.steps = {sweep};
  const MotionPlan plan(tour, RobotOptions{}, 37.5);
  double fastest = 0.0;
  int scans_up = 0;
  for (int scan = 0; scan / 37.5 < plan.duration_s(); ++scan) {
    const double tilt = plan.at(scan / 37.5).tilt_rad, next = plan.at((scan + 1) / 37.5).tilt_rad;
    if (next > tilt + 1e-9 && tilt >= deg_to_rad(-20) - 1e-9) ++scans_up;
    fastest = std::max(fastest, next - tilt);
  }
  EXPECT_NEAR(scans_up, 60, 25);  // the way up from -20 to 0 at the end of the tour may add some
  EXPECT_NEAR(rad_to_deg(plan.at(plan.duration_s()).tilt_rad), 0.0, 1e-9);
}

TEST(MotionPlan, AnUnknownStepIsNamed) {
  Tour tour;
  tour.steps.resize(1);
  tour.steps[0].kind = "fly";
  EXPECT_THAT(complaint([&] { MotionPlan(tour, RobotOptions{}, 37.5); }),
              ::testing::HasSubstr("fly"));
}

TEST(OdometryModel, IsOffByWhatItsOptionsSay) {
  OdometryOptions options;
  options.slip_every_m = 0.0;
  std::mt19937_64 random(3);
  OdometryModel odometry(options, Pose2{}, random);
  Pose2 odom;
  for (int i = 1; i <= 1000; ++i) odom = odometry.move_to({0.01 * i, 0, 0}, random);
  // 10 m straight: 5 % of distance, and a heading 1 deg/m off that bends the way.
  EXPECT_NEAR(std::abs(odom.translation_m().norm() / 10.0 - 1.0), 0.05, 0.01);
  EXPECT_NEAR(std::abs(rad_to_deg(odom.theta_rad)), 10.0, 0.6);
}

TEST(OdometryModel, StandingStillMovesNothing) {
  std::mt19937_64 random(3);
  OdometryModel odometry(OdometryOptions{}, Pose2{1, 2, 3}, random);
  const Pose2 first = odometry.move_to({1, 2, 3}, random);
  EXPECT_THAT(odometry.move_to({1, 2, 3}, random), IsNear(first, 1e-12, 1e-12));
}

World room() {
  World world;
  world.add_box({0, 0, 1}, {12, 12, 3}, 0, Material::plain);
  return world;
}

// Everything a simulation sends, as text.
std::string told(uint64_t seed) {
  const RayCaster rays(room());
  BatchSimulation simulation(rays, two_legs(), SimulationOptions{}, seed);
  std::string text;
  simulation.run(
      [&text](const Sample& sample, Utime sent) {
        text += std::to_string(sample.index()) + " " + std::to_string(sent.us);
        if (const auto* scan = std::get_if<LaserScan>(&sample)) {
          for (const float range_m : scan->ranges_m) text += " " + std::to_string(range_m);
        }
        if (const auto* odometry = std::get_if<OdometrySample>(&sample)) {
          text += " " + std::to_string(odometry->odom_from_robot.x_m);
        }
        text += "\n";
      },
      {});
  return text;
}

TEST(BatchSimulation, IsAFunctionOfItsSeed) {
  const std::string first = told(1);
  EXPECT_TRUE(first == told(1));
  EXPECT_FALSE(first == told(2));
}

TEST(BatchSimulation, SendsInOrderOfTimeAtTheRatesItSays) {
  const RayCaster rays(room());
  BatchSimulation simulation(rays, two_legs(), SimulationOptions{}, 1);
  std::array<int, 6> counts{};
  int raw = 0;
  int64_t last_us = 0;
  simulation.run(
      [&](const Sample& sample, Utime sent) {
        EXPECT_GE(sent.us, last_us);
        last_us = sent.us;
        const auto* scan = std::get_if<LaserScan>(&sample);
        if (scan != nullptr && scan->channel == channels::kLidarRaw) ++raw;
        ++counts.at(sample.index());
      },
      {});
  const double seconds = simulation.duration_s();
  EXPECT_NEAR(raw, 37.5 * seconds, 2);
  EXPECT_EQ(counts[1], 2 * raw);              // each scan twice
  EXPECT_NEAR(counts[2], 50.0 * seconds, 2);  // odometry
  EXPECT_EQ(counts[5], raw);                  // a true pose each
}

}  // namespace
}  // namespace marco::sim
