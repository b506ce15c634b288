// What the time of every beam is worth: points of a laser that turns at 1 rad/s in the simulated
// lab and office, laid into the world with the true poses at the times of lidar_raw_t, and at times
// spread evenly over the scan, which is all that planar_lidar_t allows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lcm_tools/process/config.hpp"
#include "lcmtypes/channels.hpp"
#include "simulator/batch_simulation.hpp"
#include "simulator/device_lasers.hpp"

namespace marco::sim {
namespace {

struct Spread {
  double rms = 0.0;
  double p95 = 0.0;
  std::size_t count = 0;
};

Spread spread_of(std::vector<double> errors) {
  Spread spread;
  spread.count = errors.size();
  for (const double error : errors) spread.rms += error * error;
  spread.rms = std::sqrt(spread.rms / static_cast<double>(errors.size()));
  std::sort(errors.begin(), errors.end());
  spread.p95 = errors[errors.size() * 95 / 100];
  return spread;
}

SimulationOptions turning_at_1_rad_per_s(const std::string& device) {
  SimulationOptions options;
  options.laser = device_laser(device);
  options.laser.range_sigma_m = options.laser.missing_part = options.laser.footprint_deg = 0.0;
  options.robot.turn_rate_deg_per_s = rad_to_deg(1.0);
  options.robot.turn_acceleration_deg_per_s2 = 3600.0;
  return options;
}

// Turns on the spot where the shipped tour starts.
Tour turns(const std::string& shipped) {
  Tour tour = process::load_options<Tour>("config/tours/" + shipped + ".toml");
  tour.steps.clear();
  for (const double part_deg : {120.0, 240.0, 360.0}) {
    TourStep face;
    face.kind = "face";
    face.heading_deg = tour.start_heading_deg + part_deg;
    tour.steps.push_back(face);
  }
  return tour;
}

struct Errors {
  std::vector<double> surface_m;  ///< of the points to the nearest true surface
  std::vector<double> bearing_rad;
};

// @param even  times spread evenly over the scan instead of the beams' own
Errors errors_of(const RayCaster& rays,
                 const BatchSimulation& simulation,
                 const std::vector<LaserScan>& scans,
                 const LaserOptions& laser,
                 bool even) {
  Errors errors;
  for (const LaserScan& scan : scans) {
    const double first_s = (scan.utime - BatchSimulation::kStart).seconds();
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const auto range_m = static_cast<double>(scan.ranges_m[i]);
      if (range_m < laser.range_min_m || range_m > 0.999 * laser.range_max_m) continue;
      const auto own_s = static_cast<double>(scan.time_offsets_s[i]);
      const double even_s =
          laser.scan_duration_s * static_cast<double>(i) / static_cast<double>(scan.size() - 1);
      const double after_s = even ? even_s : own_s;
      const Pose3 world_from_laser = simulation.world_from_laser(first_s + after_s);
      const double bearing_rad = scan.bearing_rad(i);
      const Eigen::Vector3d point =
          world_from_laser *
          Eigen::Vector3d(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad), 0.0);
      errors.surface_m.push_back(
          static_cast<double>(rays.distance_to_surface_m(point.cast<float>(), 1.0F)));
      errors.bearing_rad.push_back(std::abs(after_s - own_s));  // at 1 rad/s
    }
  }
  return errors;
}

struct Case {
  const char* world;
  const char* device;
  double even_rms_m;  ///< at least this bad with times spread evenly
};

class BeamTimes : public ::testing::TestWithParam<Case> {};

TEST_P(BeamTimes, LayThePointsOnTheWallsWhileTheRobotTurns) {
  const Case& one = GetParam();
  const std::string name = one.world;
  const RayCaster rays(
      build_world(process::load_options<WorldSpec>("config/worlds/" + name + ".toml")));
  const SimulationOptions options = turning_at_1_rad_per_s(one.device);
  BatchSimulation simulation(rays, turns(name), options, 1);
  std::vector<LaserScan> scans;
  simulation.run([&](const Sample& sample, Utime) {
    const auto* scan = std::get_if<LaserScan>(&sample);
    if (scan != nullptr && scan->channel == channels::kLidarRaw) scans.push_back(*scan);
  });
  ASSERT_GT(scans.size(), 20U);
  const Errors own = errors_of(rays, simulation, scans, options.laser, false);
  const Errors even = errors_of(rays, simulation, scans, options.laser, true);
  const Spread own_m = spread_of(own.surface_m), even_m = spread_of(even.surface_m);
  const Spread even_rad = spread_of(even.bearing_rad);
  std::printf(
      "%s, %s: %zu points; off the surfaces by rms %.4f p95 %.4f m with the beams' times, "
      "rms %.4f p95 %.4f m with even times, whose bearings are off by rms %.3f p95 %.3f deg\n",
      one.world, one.device, own_m.count, own_m.rms, own_m.p95, even_m.rms, even_m.p95,
      rad_to_deg(even_rad.rms), rad_to_deg(even_rad.p95));
  EXPECT_LT(own_m.p95, 0.001);  // ranges are whole millimetres; glass shows what lies behind it
  EXPECT_GE(even_m.rms, one.even_rms_m);
}

INSTANTIATE_TEST_SUITE_P(LabAndOffice,
                         BeamTimes,
                         ::testing::Values(Case{"lab", "sick", 0.015},
                                           Case{"office", "sick", 0.015},
                                           Case{"lab", "hokuyo", 0.0},
                                           Case{"lab", "rplidar", 0.0}),
                         [](const auto& one) {
                           return std::string(one.param.world) + "_" + one.param.device;
                         });

}  // namespace
}  // namespace marco::sim
