#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "lcm_tools/process/batch_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"
#include "marco/slam_pose_t.hpp"
#include "marco/trajectory_t.hpp"
#include "tests/support/analytic_room.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::AnalyticRoom;

constexpr int kBeams = 91;
constexpr double kScanEveryS = 0.1;
constexpr double kScanDurationS = 0.05;
constexpr double kStateEveryS = 0.05;
constexpr double kStepRad = 2.0 / 180.0 * M_PI;

/// How robot and pan-tilt move.
struct Motion {
  std::function<Pose2(double)> world_from_robot = [](double) { return Pose2{-1.0, 0.2, 0.3}; };
  std::function<double(double)> pan_deg = [](double) { return 0.0; };
  std::function<double(double)> tilt_deg = [](double) { return 0.0; };
};

/// A step every half second, taken within a tenth: 0, then `step` further, and so on.
double stepwise(double seconds, double step) {
  const double number = std::floor(seconds / 0.5);
  return step * (number + std::max(0.0, (seconds - 0.5 * number - 0.4) / 0.1));
}

/// A robot in the analytic room: its messages go to the adapter, and the truth is known of every
/// beam.
class Sweeps : public ::testing::Test {
 protected:
  Sweeps() : adapter_(bus_, Mapping3dAdapterOptions{}) {
    base_.channel = channels::kPanTiltState;
    base_.parent_from_sensor = make_pose3({0.05, 0.0, 0.6});
    base_.tilt_axis_m = {0.02, 0.0, 0.1};
    laser_.channel = channels::kLidar;
    laser_.mount = SensorInfo::Mount::pantilt;
    laser_.parent_from_sensor = make_pose3({0.045, 0.0, 0.008});
    laser_.scan_duration_s = kScanDurationS;
    laser_.range_max_m = 30.0;
    give(base_);
    give(laser_);
  }
  void give(const Sample& sample) {
    const EncodedMessage message = encode_sample(sample);
    bus_.deliver(message.channel, message.bytes, message.utime);
  }
  void give_state(double at_s, const Motion& motion) {
    PanTiltState state;
    state.utime = Utime::from_seconds(at_s);
    state.pan_rad = deg_to_rad(motion.pan_deg(at_s));
    state.tilt_rad = deg_to_rad(motion.tilt_deg(at_s));
    give(state);
  }
  void give_pose(double at_s, const Pose2& world_from_robot) {
    slam_pose_t pose{};
    pose.utime = Utime::from_seconds(at_s).us;
    pose.x_m = world_from_robot.x_m;
    pose.y_m = world_from_robot.y_m;
    pose.theta_rad = world_from_robot.theta_rad;
    bus_.publish(channels::kSlamPose, pose);
    bus_.deliver_published();
  }
  Pose3 world_from_laser(double at_s, const Motion& motion) const {
    return lift(motion.world_from_robot(at_s)) *
           robot_from_pantilt_sensor(base_, laser_, deg_to_rad(motion.pan_deg(at_s)),
                                     deg_to_rad(motion.tilt_deg(at_s)));
  }
  static double beam_s(double scan_s, int beam) {
    return scan_s + kScanDurationS * beam / (kBeams - 1);
  }
  static Eigen::Vector3d ray(int beam) {
    const double bearing_rad = -0.5 * M_PI + kStepRad * beam;
    return {std::cos(bearing_rad), std::sin(bearing_rad), 0.0};
  }
  LaserScan scan(double at_s, const Motion& motion) const {
    LaserScan scan;
    scan.utime = Utime::from_seconds(at_s);
    scan.channel = channels::kLidar;
    scan.first_bearing_rad = -0.5 * M_PI;
    scan.bearing_step_rad = kStepRad;
    for (int beam = 0; beam < kBeams; ++beam) {
      const Pose3 laser = world_from_laser(beam_s(at_s, beam), motion);
      scan.ranges_m.push_back(static_cast<float>(
          AnalyticRoom::range_m(laser.translation(), laser.linear() * ray(beam))));
    }
    return scan;
  }
  void drive(const Motion& motion, double seconds) {
    for (int i = 0; kScanEveryS * i < seconds; ++i) {
      const double now_s = 10.0 + kScanEveryS * i;
      for (int k = 0; k < 2; ++k) give_state(now_s + kStateEveryS * k, motion);
      give(scan(now_s, motion));
      give_pose(now_s, motion.world_from_robot(now_s));
    }
    adapter_.finish();
  }
  /// Largest distance of a placed point from where its beam truly ended.
  double worst_point_m(const Motion& motion) const {
    double worst_m = 0.0;
    for (const Scene& scene : adapter_.mapper().scenes()) {
      const ScenePoints placed = place(scene);
      for (std::size_t row = 0; row < placed.rows; ++row) {
        for (int beam = 0; beam < kBeams; ++beam) {
          const double at_s = beam_s(scene.rows[row].utime.seconds(), beam);
          const Pose3 laser = world_from_laser(at_s, motion);
          const Eigen::Vector3d direction = laser.linear() * ray(beam);
          const Eigen::Vector3d hit =
              laser.translation() +
              AnalyticRoom::range_m(laser.translation(), direction) * direction;
          const auto at = placed.index(row, static_cast<std::size_t>(beam));
          worst_m = std::max(worst_m, (placed.points_m[at].cast<double>() - hit).norm());
        }
      }
    }
    return worst_m;
  }
  std::vector<std::size_t> rows() const {
    std::vector<std::size_t> counts;
    for (const Scene& scene : adapter_.mapper().scenes()) counts.push_back(scene.rows.size());
    return counts;
  }

  SensorInfo base_, laser_;
  process::BatchBus bus_;
  Mapping3dAdapter adapter_;
};

// Beams are placed at stamps of whole microseconds between poses 0.1 s apart: well below this.
constexpr double kToleranceM = 5e-4;

TEST_F(Sweeps, StopAndTilt) {
  Motion motion;
  motion.tilt_deg = [](double s) { return -20.0 + stepwise(s - 10.0, 1.0); };
  drive(motion, 20.0);
  ASSERT_EQ(rows().size(), 1U);
  EXPECT_GT(rows()[0], 39U);
  EXPECT_LT(worst_point_m(motion), kToleranceM);
}

TEST_F(Sweeps, StopAndPan) {
  Motion motion;
  motion.pan_deg = [](double s) { return -30.0 + stepwise(s - 10.0, 1.5); };
  motion.tilt_deg = [](double) { return 25.0; };
  drive(motion, 20.0);
  ASSERT_EQ(rows().size(), 1U);
  EXPECT_LT(worst_point_m(motion), kToleranceM);
}

TEST_F(Sweeps, FourPansOfATiltSweepEach) {
  Motion motion;
  motion.pan_deg = [](double s) { return 90.0 * std::floor((s - 10.0) / 12.0); };
  motion.tilt_deg = [](double s) { return -20.0 + stepwise(std::fmod(s - 10.0, 12.0), 2.0); };
  drive(motion, 48.0);
  EXPECT_EQ(rows().size(), 4U);
  EXPECT_LT(worst_point_m(motion), kToleranceM);
}

TEST_F(Sweeps, NoddingWhileStanding) {
  Motion motion;
  motion.tilt_deg = [](double s) { return 20.0 - std::abs(s - 14.0) * 10.0; };
  drive(motion, 8.0);
  EXPECT_EQ(rows().size(), 2U);
  EXPECT_LT(worst_point_m(motion), kToleranceM);
}

TEST_F(Sweeps, NoddingWhileDrivingAnArc) {
  Motion motion;
  motion.world_from_robot = [](double s) {
    const double heading_rad = 0.15 * (s - 10.0);
    return Pose2{-1.5 + 2.0 * std::sin(heading_rad), -1.0 + 2.0 * (1.0 - std::cos(heading_rad)),
                 heading_rad};
  };
  motion.tilt_deg = [](double s) { return -20.0 + 12.0 * (s - 10.0); };
  drive(motion, 5.0);
  ASSERT_EQ(rows().size(), 1U);
  // 0.3 m/s turning at 9 deg/s: a chord of 0.1 s leaves 0.06 mm; without the poses between, 15 mm.
  EXPECT_LT(worst_point_m(motion), kToleranceM);
}

TEST_F(Sweeps, AJumpingPanTiltClockSpoilsOnlyTheRowsAboutIt) {
  Motion motion;
  motion.tilt_deg = [](double s) { return -20.0 + 5.0 * (s - 10.0); };
  for (int i = 0; i < 80; ++i) {
    const double now_s = 10.0 + kScanEveryS * i;
    for (int k = 0; k < 2; ++k) give_state(now_s + kStateEveryS * k, motion);
    if (i == 40) {  // an hour ahead, then an hour back
      PanTiltState far;
      far.utime = Utime::from_seconds(now_s + 3600.0);
      give(far);
      far.utime = Utime::from_seconds(now_s - 3600.0);
      give(far);
    }
    give(scan(now_s, motion));
    give_pose(now_s, motion.world_from_robot(now_s));
  }
  adapter_.finish();
  EXPECT_GE(adapter_.drops().by_cause().at("pan-tilt stamp steps back"), 1);
  std::size_t used = 0;
  for (const std::size_t count : rows()) used += count;
  EXPECT_GE(used, 75U);
  EXPECT_LT(worst_point_m(motion), kToleranceM);
}

TEST_F(Sweeps, FollowTheirKeyScansThroughTwoCorrections) {
  Motion motion;
  motion.tilt_deg = [](double s) { return -20.0 + 5.0 * (s - 10.0); };
  drive(motion, 6.0);
  const Pose2 first_pose = motion.world_from_robot(10.0);
  const ScenePoints before = place(adapter_.mapper().scenes()[0]);
  for (const Pose2& correction : {Pose2{0.1, -0.2, 0.05}, Pose2{0.3, 0.4, -0.1}}) {
    trajectory_t message{};
    const Pose2 today = correction * first_pose;
    message = to_message({{Utime::from_seconds(10.0), today}}, Utime::from_seconds(20.0), 1);
    bus_.publish(channels::kTrajectory, message);
    bus_.deliver_published();
    const ScenePoints after = place(adapter_.mapper().scenes()[0]);
    const Eigen::Vector3d expected = lift(correction) * before.points_m[5].cast<double>();
    EXPECT_NEAR((after.points_m[5].cast<double>() - expected).norm(), 0.0, 1e-5);
  }
}

}  // namespace
}  // namespace marco::mapping3d
