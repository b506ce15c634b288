// The faults of a small rover's recordings, as they stand in the log.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "simulator/batch_simulation.hpp"
#include "tests/support/matchers.hpp"

namespace marco::sim {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;

// A rover without noise, whose clocks agree.
SimulationOptions exact_rover(const std::string& beam_times = "right") {
  SimulationOptions options = rover_options(5.0, 208);
  options.laser.range_sigma_m = options.laser.missing_part = options.laser.footprint_deg = 0.0;
  options.logger = {};
  options.logger.beam_times = beam_times;
  options.odometry.floor_tilt_deg = 0.0;
  return options;
}

World small_room() {
  World world;
  world.add_box({1, 0.5, 1}, {6, 4, 3}, 0, Material::plain);
  return world;
}

// A way, and turns on the spot.
Tour way_and_turns() {
  Tour tour;
  tour.steps.resize(4);
  tour.steps[0].to_m = {1.5, 0.5};
  for (std::size_t i = 1; i < tour.steps.size(); ++i) {
    tour.steps[i].kind = "face";
    tour.steps[i].heading_deg = 120.0 * static_cast<double>(i);
  }
  return tour;
}

// What a log of the tour holds, in bytes and back.
struct Log {
  std::vector<LaserScan> raw, planar;
  std::vector<OdometrySample> odometry;
  std::vector<TruePose> truth;
  std::vector<SensorInfo> infos;
  int pantilt = 0;
};

Log log_of(const RayCaster& rays, const SimulationOptions& options, uint64_t seed = 1) {
  Log log;
  BatchSimulation(rays, way_and_turns(), options, seed).run([&log](const Sample& sample, Utime) {
    const EncodedMessage message = encode_sample(sample);
    const Sample logged = decode_sample(message.channel, message.bytes).value();
    if (const auto* scan = std::get_if<LaserScan>(&logged)) {
      (scan->channel == channels::kLidarRaw ? log.raw : log.planar).push_back(*scan);
    }
    if (const auto* odometry = std::get_if<OdometrySample>(&logged)) {
      log.odometry.push_back(*odometry);
    }
    if (const auto* pose = std::get_if<TruePose>(&logged)) log.truth.push_back(*pose);
    if (const auto* info = std::get_if<SensorInfo>(&logged)) log.infos.push_back(*info);
    if (std::holds_alternative<PanTiltState>(logged)) ++log.pantilt;
  });
  return log;
}

double span_s(const LaserScan& scan) {
  const auto [first, last] =
      std::minmax_element(scan.time_offsets_s.begin(), scan.time_offsets_s.end());
  return static_cast<double>(*last - *first);
}

// How far the beams' ends lie from the walls when each is laid where the robot was at its time; the
// largest of the log.
double off_the_walls_m(const RayCaster& rays,
                       const SimulationOptions& options,
                       const std::vector<LaserScan>& scans,
                       const std::function<double(std::size_t)>& time_of_beam_s) {
  const BatchSimulation simulation(rays, way_and_turns(), options, 1);
  double worst_m = 0.0;
  for (const LaserScan& scan : scans) {
    const double began_s = (scan.utime - BatchSimulation::kStart).seconds();
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const auto range_m = static_cast<double>(scan.ranges_m[i]);
      const double bearing_rad = scan.bearing_rad(i);
      const Eigen::Vector3d end =
          simulation.world_from_laser(began_s + time_of_beam_s(i)) *
          Eigen::Vector3d(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad), 0.0);
      worst_m = std::max(worst_m,
                         static_cast<double>(rays.distance_to_surface_m(end.cast<float>(), 5.0F)));
    }
  }
  return worst_m;
}

TEST(Rover, TurnsFastAndSeesEachBeamFromItsOwnPlace) {
  const RayCaster rays(small_room());
  const SimulationOptions options = exact_rover();
  const Log log = log_of(rays, options);
  ASSERT_GT(log.raw.size(), 20U);
  double fastest_rad = 0.0;
  for (std::size_t i = 1; i < log.truth.size(); ++i) {
    const Pose2 moved = between(log.truth[i - 1].world_from_robot, log.truth[i].world_from_robot);
    fastest_rad = std::max(fastest_rad, std::abs(moved.theta_rad));
  }
  EXPECT_GT(rad_to_deg(fastest_rad), 40.0);  // 230 deg/s for 0.2 s, less the ramps
  const auto own = [&](std::size_t i) { return options.laser.time_of_beam_s(static_cast<int>(i)); };
  EXPECT_LT(off_the_walls_m(rays, options, log.raw, own), 0.001);  // ranges in whole millimetres
  EXPECT_GT(off_the_walls_m(rays, options, log.raw, [](std::size_t) { return 0.0; }), 0.5);
}

TEST(Rover, ReversedTimesRunAgainstTheMirror) {
  const RayCaster rays(small_room());
  const SimulationOptions options = exact_rover("reversed");
  const Log log = log_of(rays, options);
  ASSERT_GT(log.raw.size(), 20U);
  EXPECT_TRUE(log.planar.empty());
  for (const LaserScan& scan : log.raw) {
    ASSERT_TRUE(std::is_sorted(scan.time_offsets_s.begin(), scan.time_offsets_s.end()));
    ASSERT_NEAR(span_s(scan), options.laser.scan_duration_s, 2e-6);
  }
  const auto said = [&](std::size_t i) {
    return options.laser.time_of_beam_s(static_cast<int>(i));
  };
  const auto against = [&](std::size_t i) { return options.laser.scan_duration_s - said(i); };
  EXPECT_LT(off_the_walls_m(rays, options, log.raw, against), 0.001);
  EXPECT_GT(off_the_walls_m(rays, options, log.raw, said), 0.5);
}

TEST(Rover, BeamTimesAreLoggedAsChosenAndTheScansStayTheSame) {
  const RayCaster rays(small_room());
  const Log right = log_of(rays, exact_rover());
  ASSERT_GT(right.raw.size(), 20U);
  EXPECT_EQ(right.planar.size(), right.raw.size());
  const double duration_s = exact_rover().laser.scan_duration_s;
  EXPECT_NEAR(duration_s, 0.2 * 207 / 208, 1e-9);
  EXPECT_NEAR(right.infos.at(0).scan_duration_s, duration_s, 1e-9);
  for (const char* fault : {"milliseconds", "equal", "missing"}) {
    const Log log = log_of(rays, exact_rover(fault));
    const bool is_missing = fault == std::string("missing");
    const auto& scans = is_missing ? log.planar : log.raw;
    EXPECT_TRUE((is_missing ? log.raw : log.planar).empty()) << fault;
    EXPECT_EQ(log.infos.at(0).scan_duration_s, 0.0) << fault;
    ASSERT_EQ(scans.size(), right.raw.size()) << fault;
    for (std::size_t i = 0; i < scans.size(); ++i) {
      EXPECT_EQ(scans[i].utime, right.raw[i].utime);
      EXPECT_EQ(scans[i].ranges_m, right.raw[i].ranges_m);
      // 199 us where 199 038 us were meant.
      const double said_s = fault == std::string("milliseconds") ? duration_s / 1000 : 0.0;
      if (is_missing) continue;
      EXPECT_NEAR(span_s(scans[i]), said_s, 1e-6);
    }
  }
}

TEST(Rover, StampsAreLateAndDriftWhileTruthIsOfTheTrueTime) {
  const RayCaster rays(small_room());
  SimulationOptions options = exact_rover();
  options.logger.stamp_late_s = 0.08;
  options.logger.clock_drift = 0.004;
  const Log log = log_of(rays, options);
  const MotionPlan plan(way_and_turns(), options.robot, options.laser.scans_per_s);
  ASSERT_GT(log.raw.size(), 20U);
  for (std::size_t i = 0; i < log.raw.size(); ++i) {
    const double began_s = static_cast<double>(i) / 5.0;
    const Utime stamp = BatchSimulation::kStart + Duration::from_seconds(began_s * 1.004 + 0.08);
    EXPECT_NEAR((log.raw[i].utime - stamp).seconds(), 0.0, 2e-6);
    EXPECT_EQ(log.truth[i].utime, log.raw[i].utime);
    EXPECT_THAT(log.truth[i].world_from_robot,
                IsNear(plan.at(began_s).world_from_robot, 1e-9, 1e-9));
    EXPECT_NEAR(span_s(log.raw[i]), 1.004 * options.laser.scan_duration_s, 2e-6);
  }
}

TEST(Rover, TellsItsOdometryAsChosen) {
  const RayCaster rays(small_room());
  SimulationOptions options = exact_rover();
  EXPECT_TRUE(log_of(rays, options).odometry.empty());
  options.robot.odometry = "still";
  const Log still = log_of(rays, options);
  ASSERT_GT(still.odometry.size(), 100U);
  for (const OdometrySample& sample : still.odometry) {
    EXPECT_THAT(sample.odom_from_robot, IsNear(Pose2{}, 0.0, 0.0));
  }
  options.robot.odometry = "gyro";
  const Log gyro = log_of(rays, options);
  const MotionPlan plan(way_and_turns(), options.robot, options.laser.scans_per_s);
  ASSERT_EQ(gyro.odometry.size(), still.odometry.size());
  double turned_rad = 0.0;
  for (const OdometrySample& sample : gyro.odometry) {
    const double seconds = (sample.utime - BatchSimulation::kStart).seconds();
    const Pose2 at = plan.at(seconds).world_from_robot;
    turned_rad = std::max(turned_rad, std::abs(at.theta_rad));
    // Of a whole turn and the turn into the way before it, `turn_error` is missing or too much.
    EXPECT_THAT(sample.odom_from_robot,
                IsNear(Pose2{0, 0, at.theta_rad}, 0.0, 0.02 * deg_to_rad(400) + 1e-9));
  }
  EXPECT_GT(turned_rad, 2.0);
}

TEST(Rover, HasNoPanTilt) {
  const RayCaster rays(small_room());
  const SimulationOptions options = exact_rover();
  const Log log = log_of(rays, options);
  EXPECT_EQ(log.pantilt, 0);
  for (const SensorInfo& info : log.infos) {
    EXPECT_EQ(info.channel, channels::kLidar);
    EXPECT_EQ(info.mount, SensorInfo::Mount::robot);
    EXPECT_NEAR(info.parent_from_sensor.translation().z(), 0.15, 1e-12);
  }
  Tour sweeping = way_and_turns();
  sweeping.steps[1].kind = "sweep";
  EXPECT_THAT(complaint([&] { BatchSimulation(rays, sweeping, options, 1); }),
              ::testing::HasSubstr("no pan-tilt"));
}

TEST(Rover, UnknownFaultsAreNamed) {
  const RayCaster rays(small_room());
  EXPECT_THAT(complaint([&] { log_of(rays, exact_rover("minutes")); }),
              ::testing::HasSubstr("minutes"));
  SimulationOptions options = exact_rover();
  options.robot.odometry = "sundial";
  EXPECT_THAT(complaint([&] { log_of(rays, options); }), ::testing::HasSubstr("sundial"));
}

}  // namespace
}  // namespace marco::sim
