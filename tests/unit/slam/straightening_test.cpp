#include "slam/front_end/straightening.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "slam/slam.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

constexpr double kScanPeriodS = 0.2;
constexpr int kRoverBeams = 208;

/// A small rover without odometry in a room: a laser that turns five times a second, 2.2 cm of
/// noise.
class Rover {
 public:
  enum class Drive { stands, turns_to_and_fro, turns_back_at_once };

  explicit Rover(Drive drive, bool clockwise = false) : drive_(drive), clockwise_(clockwise) {
    world_.add_box(-2.5, -2.0, 3.0, 2.5);
    world_.add_box(1.5, 1.0, 2.0, 1.6);
    world_.add_box(-2.0, -2.0, -1.4, -1.2);
  }

  Pose2 at(double seconds) const {
    if (drive_ == Drive::stands) return {};
    if (drive_ == Drive::turns_back_at_once) return {0.0, 0.0, heading_rad(seconds)};
    // From rest, up to 172 degrees a second.
    return {0.3 * std::sin(0.5 * seconds), 0.2 * std::sin(0.3 * seconds),
            normalize_angle(2.0 * (1.0 - std::cos(1.5 * seconds)))};
  }
  LaserScan scan(int index) {
    LaserScan scan;
    scan.utime = Utime::from_seconds(100.0 + kScanPeriodS * index);
    scan.bearing_step_rad = 2.0 * std::numbers::pi / kRoverBeams;
    for (int beam = 0; beam < kRoverBeams; ++beam) {
      const int turned = clockwise_ ? kRoverBeams - 1 - beam : beam;
      const double since_s = kScanPeriodS * turned / kRoverBeams;
      const Pose2 now = at(kScanPeriodS * index + since_s);
      const double range_m =
          world_.range_m(now.translation_m(), now.theta_rad + scan.bearing_rad(beam));
      scan.ranges_m.push_back(static_cast<float>(range_m + 0.022 * normal_(random_)));
      scan.time_offsets_s.push_back(static_cast<float>(since_s));
    }
    return scan;
  }

 private:
  // Stands for 2 s, then turns by 229 degrees a second, and back again every 1.27 s.
  static double heading_rad(double seconds) {
    constexpr double kRateRadPerS = 4.0, kHalfPeriodS = 1.27;
    const double phase = std::fmod(std::max(0.0, seconds - 2.0), 2.0 * kHalfPeriodS);
    return normalize_angle(kRateRadPerS * std::min(phase, 2.0 * kHalfPeriodS - phase));
  }

  Drive drive_;
  bool clockwise_;
  testing::FlatWorld world_;
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_{0.0, 1.0};
};

SlamInput input_of(const LaserScan& scan, const Slam& slam) {
  SlamInput input;
  input.scan = deskew_and_project(scan, {}, Pose3::Identity(),
                                  slam.velocity_during({}, kScanPeriodS).velocity);
  input.motion.utime = scan.utime;
  input.motion.scan_period_s = kScanPeriodS;
  return input;
}

// Root mean square of the heading's error, from a third of the way on.
double heading_error_rad(bool as_predicted) {
  Rover rover(Rover::Drive::turns_to_and_fro);
  Slam slam;
  constexpr int kScans = 150;
  double squares = 0.0;
  for (int i = 0; i < kScans; ++i) {
    SlamInput input = input_of(rover.scan(i), slam);
    input.deskewed_by_odometry = as_predicted;
    const Pose2 found = slam.process(input).world_from_robot;
    const Pose2 truth = between(rover.at(0.0), rover.at(kScanPeriodS * i));
    if (i > kScans / 3) squares += std::pow(normalize_angle(found.theta_rad - truth.theta_rad), 2);
  }
  return std::sqrt(squares / (kScans - kScans / 3));
}

TEST(Straightening, HalvesTheErrorOfScansDeskewedByAPrediction) {
  const double straightened = heading_error_rad(false), predicted = heading_error_rad(true);
  EXPECT_LT(straightened, 0.5 * predicted) << predicted;
}

bool is_lost(const Pose2& found, const Pose2& truth) {
  return std::abs(normalize_angle(found.theta_rad - truth.theta_rad)) > deg_to_rad(15.0);
}

// Scans during which it turns back fit no turn rate, and those behind them nothing that was
// predicted.
TEST(Straightening, FindsARobotAgainThatTurnedBackAtOnce) {
  for (const bool clockwise : {false, true}) {
    Rover rover(Rover::Drive::turns_back_at_once, clockwise);
    Slam slam;
    int lost = 0;
    constexpr int kScans = 200;
    for (int i = 0; i < kScans; ++i) {
      const Pose2 found = slam.process(input_of(rover.scan(i), slam)).world_from_robot;
      if (is_lost(found, rover.at(kScanPeriodS * i))) ++lost;
    }
    EXPECT_LT(lost, kScans / 10) << clockwise;
  }
}

// The first turn already, against odometry that was right as long as the robot stood.
TEST(Straightening, FindsARobotWhoseOdometryNeverMoves) {
  Rover rover(Rover::Drive::turns_back_at_once);
  Slam slam;
  int lost = 0;
  for (int i = 0; i < 20; ++i) {
    const LaserScan scan = rover.scan(i);
    SlamInput input = input_of(scan, slam);
    const ScanVelocity velocity = slam.velocity_during(Pose2{}, kScanPeriodS);
    input.scan = deskew_and_project(scan, {}, Pose3::Identity(), velocity.velocity);
    input.deskewed_by_odometry = velocity.by_odometry;
    input.motion.odom_from_robot = Pose2{};
    if (is_lost(slam.process(input).world_from_robot, rover.at(kScanPeriodS * i))) ++lost;
  }
  EXPECT_LE(lost, 1);
}

TEST(Straightening, TheRightTimesOfBeamsFitBestWhileTheRobotTurns) {
  Rover rover(Rover::Drive::turns_to_and_fro);
  Slam slam;
  double right = 0.0, reversed = 0.0, at_once = 0.0;
  int turning = 0;
  for (int i = 0; i < 100; ++i) {
    const LaserScan scan = rover.scan(i);
    SlamInput input = input_of(scan, slam);
    input.rival_times_s = {{scan.time_offsets_s.rbegin(), scan.time_offsets_s.rend()},
                           std::vector<float>(kRoverBeams, 0.1F)};
    const SlamUpdate update = slam.process(input);
    if (update.misfits_m2.empty()) continue;
    ++turning;
    right += update.misfits_m2[0];
    reversed += update.misfits_m2[1];
    at_once += update.misfits_m2[2];
  }
  EXPECT_GT(turning, 50);
  EXPECT_LT(right, 0.9 * at_once);
  EXPECT_LT(right, 0.7 * reversed);
}

TEST(Straightening, ScansOfARobotThatStandsTellNoOrderOfBeams) {
  Rover rover(Rover::Drive::stands);
  Slam slam;
  for (int i = 0; i < 30; ++i) {
    SlamInput input = input_of(rover.scan(i), slam);
    input.rival_times_s = {std::vector<float>(kRoverBeams, 0.1F),
                           std::vector<float>(kRoverBeams, 0.1F)};
    EXPECT_TRUE(slam.process(input).misfits_m2.empty());
  }
}

TEST(StandingStill, WithNoisyScansGoesNowhere) {
  Rover rover(Rover::Drive::stands);
  Slam slam;
  constexpr int kScans = 120;
  double way_m = 0.0, squares = 0.0;
  Pose2 before;
  for (int i = 0; i < kScans; ++i) {
    SlamInput input = input_of(rover.scan(i), slam);
    input.motion.odom_from_robot = Pose2{1.0, 2.0, 0.5};
    const Pose2 now = slam.process(input).world_from_robot;
    way_m += between(before, now).translation_m().norm();
    squares += now.translation_m().squaredNorm();
    before = now;
  }
  EXPECT_LT(std::sqrt(squares / kScans), 0.004);
  EXPECT_LT(way_m, 0.05);
}

}  // namespace
}  // namespace marco::slam
