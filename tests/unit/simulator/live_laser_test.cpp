// The batch simulation writes what a live robot would publish: the same tour, once through the
// laser model with the device's beam order, once beam by beam through the emulator, its line and
// its driver.
#include "simulator/live/live_laser.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drivers/cola/driver.hpp"
#include "drivers/hokuyo/driver.hpp"
#include "drivers/laser/regular_scan.hpp"
#include "drivers/ldlidar/driver.hpp"
#include "drivers/leuze/driver.hpp"
#include "drivers/rplidar/driver.hpp"
#include "drivers/sick/driver.hpp"
#include "drivers/ydlidar/driver.hpp"
#include "lcmtypes/channels.hpp"
#include "simulator/batch_simulation.hpp"
#include "simulator/device_lasers.hpp"
#include "simulator/devices/transport/simulated_line.hpp"

namespace marco::sim {
namespace {

using drivers::ByteStream;
using drivers::LaserDriver;

// No edges: a beam that is off by a microsecond sees nearly the same.
World box_room() {
  World world;
  world.add_box({0, 0, 1}, {5, 4, 6}, 0.3, Material::plain);
  return world;
}

SimulationOptions exact(const std::string& device) {
  SimulationOptions options;
  options.laser = device_laser(device);
  options.laser.range_sigma_m = options.laser.missing_part = options.laser.footprint_deg = 0.0;
  options.robot.turn_rate_deg_per_s = rad_to_deg(1.0);
  return options;
}

// Turns at 1 rad/s for long enough to set a laser up, and longer.
Tour turning() {
  Tour tour;
  for (int i = 1; i <= 5; ++i) {
    TourStep face;
    face.kind = "face";
    face.heading_deg = 120.0 * i;
    tour.steps.push_back(face);
  }
  return tour;
}

std::unique_ptr<LaserDriver> driver_of(const std::string& device,
                                       ByteStream& stream,
                                       const drivers::Clock& clock) {
  if (device == "sick") {
    drivers::sick::SickOptions options;
    options.baud = 500'000;
    return std::make_unique<drivers::sick::SickDriver>(stream, options, clock);
  }
  if (device == "hokuyo") {
    return std::make_unique<drivers::hokuyo::HokuyoDriver>(stream, drivers::hokuyo::HokuyoOptions{},
                                                           clock);
  }
  if (device == "rplidar") {
    return std::make_unique<drivers::rplidar::RplidarDriver>(
        stream, drivers::rplidar::RplidarOptions{}, clock);
  }
  if (device == "ld19") {
    return std::make_unique<drivers::ldlidar::LdlidarDriver>(
        stream, drivers::ldlidar::LdlidarOptions{}, clock);
  }
  if (device == "ydlidar_x4") {
    return std::make_unique<drivers::ydlidar::YdlidarDriver>(
        stream, drivers::ydlidar::YdlidarOptions{}, clock);
  }
  if (device == "tim561") {
    return std::make_unique<drivers::cola::ColaDriver>(stream, drivers::cola::ColaOptions{}, clock);
  }
  drivers::leuze::LeuzeOptions options;
  options.baud = 115'200;
  options.geometry.scale = drivers::leuze::thesis_a_geometry().scale;
  return std::make_unique<drivers::leuze::LeuzeDriver>(stream, options, clock);
}

struct Live {
  std::vector<LaserScan> scans;
  drivers::LaserProperties properties;
};

class LiveAndBatch : public ::testing::TestWithParam<const char*> {
 protected:
  LiveAndBatch()
      : rays_(box_room()), options_(exact(device_)), simulation_(rays_, turning(), options_, 1) {
    simulation_.run([&](const Sample& sample, Utime) {
      if (const auto* info = std::get_if<SensorInfo>(&sample)) {
        if (info->channel == channels::kLidar) info_ = *info;
      }
      const auto* scan = std::get_if<LaserScan>(&sample);
      if (scan == nullptr) return;
      (scan->channel == channels::kLidarRaw ? raw_ : planar_).push_back(*scan);
    });
  }

  /// The tour through emulator and driver. @param start  when the line is opened and the mirror
  /// begins to turn
  Live drive(Utime start) {
    LiveLaserSpec spec;
    spec.device = device_;
    spec.baud = device_ == "leuze" ? 115'200 : 0;
    spec.optics = options_.laser;
    LiveLaser laser(
        rays_, spec,
        [this](Utime when) {
          return simulation_.world_from_laser((when - BatchSimulation::kStart).seconds());
        },
        no_faults_, 1);
    const auto emulator = laser_emulator(
        spec, [&laser](const drivers::LaserSweep& sweep) { return laser.sweep(sweep); });
    drivers::SimulatedLine line(*emulator, true, start);
    const auto stream = line.open({9600});
    const auto driver = driver_of(device_, *stream, [&line] { return line.now(); });
    Live live;
    const Utime end = BatchSimulation::kStart + Duration::from_seconds(simulation_.duration_s());
    while (line.now() < end) {
      for (const drivers::ArrivedScan& arrived : driver->step()) {
        live.scans.push_back(arrived.scan);
      }
    }
    live.properties = driver->properties();
    return live;
  }

  /// As above, with the mirror in step with the batch simulation's.
  Live drive_in_step() {
    const Utime start = BatchSimulation::kStart;
    const std::vector<LaserScan> scans = drive(start).scans;
    if (scans.empty()) return {};
    const double period_s = 1.0 / options_.laser.scans_per_s;
    const double after_s = std::fmod((scans.back().utime - start).seconds(), period_s);
    return drive(start - Duration::from_seconds(after_s));
  }

  const LaserScan* batch_scan_at(Utime utime) const {
    for (const LaserScan& scan : raw_) {
      if (std::abs((scan.utime - utime).seconds()) < 5e-4) return &scan;
    }
    return nullptr;
  }

  std::string device_ = GetParam();
  RayCaster rays_;
  SimulationOptions options_;
  BatchSimulation simulation_;
  FaultBoard no_faults_;
  SensorInfo info_;
  std::vector<LaserScan> raw_, planar_;
};

TEST_P(LiveAndBatch, PublishTheSameStampsAndRanges) {
  const Live live = drive_in_step();
  ASSERT_GT(live.scans.size(), 8U);
  std::size_t compared = 0;
  double worst_stamp_s = 0.0, worst_offset_s = 0.0, worst_range_m = 0.0;
  for (const LaserScan& scan : live.scans) {
    const LaserScan* batch = batch_scan_at(scan.utime);
    if (batch == nullptr) continue;
    ++compared;
    ASSERT_EQ(scan.size(), batch->size());
    worst_stamp_s = std::max(worst_stamp_s, std::abs((scan.utime - batch->utime).seconds()));
    for (std::size_t i = 0; i < scan.size(); ++i) {
      EXPECT_NEAR(normalize_angle(scan.bearing_rad(i) - batch->bearing_rad(i)), 0.0, 1e-6);
      const auto difference = [i](const std::vector<float>& a, const std::vector<float>& b) {
        return std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
      };
      worst_offset_s =
          std::max(worst_offset_s, difference(scan.time_offsets_s, batch->time_offsets_s));
      worst_range_m = std::max(worst_range_m, difference(scan.ranges_m, batch->ranges_m));
    }
  }
  std::printf(
      "%s: %zu of %zu scans in step; stamps within %.1f us, beams' times within %.1f us, "
      "ranges within %.1f mm\n",
      device_.c_str(), compared, live.scans.size(), 1e6 * worst_stamp_s, 1e6 * worst_offset_s,
      1e3 * worst_range_m);
  EXPECT_GE(compared, live.scans.size() * 9 / 10);
  EXPECT_LT(worst_stamp_s, 1e-4);
  // An LD19's period is learned: to 5e-5 of it, over a turn of 0.1 s.
  EXPECT_LT(worst_offset_s, device_ == "ld19" ? 5e-6 : 2e-6);
  // Each rounds to its unit; 1 rad/s along the walls makes 0.6 mm of 0.1 ms.
  EXPECT_LT(worst_range_m, options_.laser.quantum_m + 1e-3);
  EXPECT_NEAR(live.properties.scan_duration_s, info_.scan_duration_s, 2e-5);
  EXPECT_NEAR(live.properties.range_max_m, info_.range_max_m, 1e-5);  // a float's
  EXPECT_EQ(live.properties.range_min_m, info_.range_min_m);
}

TEST_P(LiveAndBatch, ThePlanarScanIsTheRawOneWithoutTimes) {
  ASSERT_EQ(raw_.size(), planar_.size());
  ASSERT_GT(raw_.size(), 8U);
  for (std::size_t i = 0; i < raw_.size(); ++i) {
    EXPECT_EQ(planar_[i].channel, channels::kLidar);
    EXPECT_EQ(planar_[i].utime, raw_[i].utime);
    EXPECT_EQ(planar_[i].ranges_m, raw_[i].ranges_m);
    EXPECT_TRUE(planar_[i].time_offsets_s.empty());
    const std::vector<float>& times_s = raw_[i].time_offsets_s;
    const float last_s = *std::max_element(times_s.begin(), times_s.end());
    EXPECT_NEAR(static_cast<double>(last_s), info_.scan_duration_s, 5e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(Devices,
                         LiveAndBatch,
                         ::testing::Values("sick", "hokuyo", "ld19", "tim561", "leuze"),
                         [](const auto& one) { return std::string(one.param); });

// Turns that are no whole number of samples: the scans are compared with the world, at the bearing
// and time that each beam claims.
class LiveTurns : public LiveAndBatch {};

TEST_P(LiveTurns, MeasuresWhatTheWorldShowsAtEachBeamsTime) {
  const Live live = drive(BatchSimulation::kStart);
  ASSERT_GT(live.scans.size(), 8U);
  LaserOptions one_beam = options_.laser;
  one_beam.beams = 2;
  one_beam.quantum_m = one_beam.scan_duration_s = 0.0;
  std::mt19937_64 random(1);
  const double samples = 360.0 / -one_beam.step_deg, turn_s = 1.0 / one_beam.scans_per_s;
  double worst_m = 0.0;
  const std::vector<LaserScan>* const both[] = {&live.scans, &raw_};
  for (const std::vector<LaserScan>* scans : both) {
    for (const LaserScan& scan : *scans) {
      EXPECT_NEAR(static_cast<double>(scan.size()), samples, 1.0);
      EXPECT_NEAR(static_cast<double>(scan.time_offsets_s.back()), turn_s, 2.0 * turn_s / samples);
      const double first_s = (scan.utime - BatchSimulation::kStart).seconds();
      for (std::size_t i = 0; i < scan.size(); i += 7) {
        one_beam.first_bearing_deg = rad_to_deg(scan.bearing_rad(i));
        const Pose3 pose =
            simulation_.world_from_laser(first_s + static_cast<double>(scan.time_offsets_s[i]));
        const float true_m =
            LaserModel(rays_, one_beam).scan([&](double) { return LaserMoment{pose}; }, random)[0];
        worst_m = std::max(worst_m, static_cast<double>(std::abs(scan.ranges_m[i] - true_m)));
      }
    }
  }
  std::printf("%s: ranges within %.1f mm of the world's\n", device_.c_str(), 1e3 * worst_m);
  // Angles of 1/64 deg at a slant, a millimetre of the capsule's, 0.1 ms at 1 rad/s.
  EXPECT_LT(worst_m, 0.004);
}

INSTANTIATE_TEST_SUITE_P(Devices, LiveTurns, ::testing::Values("rplidar", "ydlidar_x4"));

}  // namespace
}  // namespace marco::sim
