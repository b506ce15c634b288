#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "common/regular_scan.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"
#include "lcmtypes/convert.hpp"
#include "recordings/import_recording.hpp"
#include "recordings/lcm_log_reader.hpp"
#include "recordings/recording.hpp"
#include "tools/log/export_carmen.hpp"

namespace marco::logs {
namespace {

struct Exported {
  CarmenResult result;
  std::string carmen, truth;
};

Exported export_log(const std::string& log, const ScratchFolder& folder) {
  OutputFile out(folder / "out.log", Existing::replace, {});
  OutputFile truth(folder / "out.truth", Existing::replace, {});
  Exported exported;
  exported.result = export_carmen(*open_lcm_log(log), out, &truth, ignore_progress);
  out.finish();
  truth.finish();
  exported.carmen = read_text(folder / "out.log");
  exported.truth = read_text(folder / "out.truth");
  return exported;
}

void import_file(const std::string& in, const std::string& path) {
  OutputFile out(path, Existing::replace, {});
  import_recording(in, out, ignore_progress);
  out.finish();
}

std::vector<LaserScan> scans_of(const std::string& path) {
  const auto recording = open_recording(path);
  std::vector<LaserScan> scans;
  while (auto sample = recording->next()) {
    if (auto* scan = std::get_if<LaserScan>(&*sample)) scans.push_back(std::move(*scan));
  }
  return scans;
}

std::string flaser(double time_s, double x_m, const char* keyword = "FLASER") {
  std::string line = std::string(keyword) + " 180";
  for (int i = 0; i < 180; ++i)
    line += i % 7 == 0 ? " 81.83" : " " + std::to_string(1 + i % 30) + ".07";
  char rest[200];
  std::snprintf(rest, sizeof rest, " %.2f 0.5 0.25 %.2f 0.5 0.25 %.6f host %.6f\n", x_m, x_m,
                time_s, time_s);
  return line + rest;
}

TEST(Import, GivesLidarOdometryAndSensorInfoEachSecond) {
  const ScratchFolder folder;
  std::string text;
  for (int i = 0; i < 30; ++i) text += flaser(976052857.1 + 0.1 * i, 0.01 * i);
  write_text(folder / "in.log", text);
  import_file(folder / "in.log", folder / "out.lcm");
  std::map<std::string, int> counts;
  int64_t last_us = 0;
  for (const auto& event : read_events(folder / "out.lcm")) {
    ++counts[event.channel];
    EXPECT_GE(event.event_time.us, last_us);
    last_us = event.event_time.us;
  }
  EXPECT_EQ(counts["LIDAR"], 30);
  EXPECT_EQ(counts["ODOMETRY"], 30);
  EXPECT_EQ(counts["SENSOR_INFO"], 3);  // at 0, 1 and 2 s
}

TEST(CarmenRoundTrip, GivesTheSameScansPosesAndTimes) {
  const ScratchFolder folder;
  std::string text;
  for (int i = 0; i < 30; ++i) {
    // A bursty clock: stamps that step backwards.
    text += flaser(976052857.1 + 0.1 * i - (i % 9 == 0 ? 0.55 : 0.0), 0.01 * i);
    text += flaser(976052857.1 + 0.1 * i, 0.01 * i, "RLASER");
  }
  write_text(folder / "in.log", text);
  import_file(folder / "in.log", folder / "one.lcm");
  const Exported exported = export_log(folder / "one.lcm", folder);
  EXPECT_EQ(exported.result.scans, 60);
  EXPECT_EQ(exported.result.without_odometry, 0);
  EXPECT_EQ(exported.result.resampled, 0);
  // The line's numbers are written as they were read.
  std::istringstream before(text), after(exported.carmen);
  std::string line, written;
  for (int i = 0; i < 60; ++i) {
    std::getline(before, line);
    do std::getline(after, written);
    while (written.find("LASER") != 1);
    const std::string ranges = line.substr(0, line.find(" 0.5 0.25"));
    EXPECT_EQ(written.substr(0, ranges.rfind(' ')), ranges.substr(0, ranges.rfind(' ')));
  }
  import_file(folder / "out.log", folder / "two.lcm");
  const auto first = read_events(folder / "one.lcm"), second = read_events(folder / "two.lcm");
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].channel, second[i].channel) << i;
    EXPECT_EQ(first[i].bytes, second[i].bytes) << i << " " << first[i].channel;
  }
}

TEST(ExportCarmen, ALaserElsewhereKeepsItsPlaceAndTruthIsAPoseFile) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "in.lcm");
    const auto write = [&](const Sample& sample) {
      const EncodedMessage message = encode_sample(sample);
      writer.write(message.channel, message.bytes, message.utime);
    };
    SensorInfo info;
    info.utime = Utime::from_us(kStartUs);
    info.parent_from_sensor = lift({0.2, 0.1, 0.5});
    info.range_max_m = 30.0;
    write(info);
    for (int i = 0; i < 5; ++i) {
      const Utime time = Utime::from_us(kStartUs + 100000 * i);
      // The scan comes before the odometry of its own time.
      LaserScan scan;
      scan.utime = time + Duration::from_us(50000);
      scan.ranges_m = {1.0F, 2.5F, 30.0F};
      scan.first_bearing_rad = -1.0;
      scan.bearing_step_rad = 1.0;
      OdometrySample odometry;
      odometry.utime = time;
      odometry.odom_from_robot = {0.1 * i, 0.0, 0.0};
      write(odometry);
      write(scan);
      write(TruePose{time, {1.0, 2.0, 0.0}});
    }
  }
  const Exported exported = export_log(folder / "in.lcm", folder);
  EXPECT_EQ(exported.result.scans, 5);
  EXPECT_EQ(exported.result.true_poses, 5);
  EXPECT_EQ(exported.truth.substr(0, exported.truth.find('\n')), "1454600000.000000 1 2 0 0 0 0 1");
  const auto recording = open_recording(folder / "out.log");
  int scans = 0;
  Pose2 odometry;
  while (const auto sample = recording->next()) {
    if (const auto* info = std::get_if<SensorInfo>(&*sample)) {
      EXPECT_TRUE(info->parent_from_sensor.isApprox(lift({0.2, 0.1, 0.5}), 1e-9));
    } else if (const auto* pose = std::get_if<OdometrySample>(&*sample)) {
      odometry = pose->odom_from_robot;
    } else if (const auto* scan = std::get_if<LaserScan>(&*sample)) {
      EXPECT_EQ(scan->ranges_m, (std::vector<float>{1.0F, 2.5F, 30.0F}));
      // Between two odometry messages; the last one is carried on.
      EXPECT_NEAR(odometry.x_m, 0.1 * scans + 0.05, 1e-6);
      ++scans;
    }
  }
  EXPECT_EQ(scans, 5);
}

TEST(RegularScan, PutsEachBeamOnTheNearestBearing) {
  LaserScan scan;
  for (int i = 0; i < 300; ++i) {  // clockwise, 1.2 deg apart
    scan.bearings_rad.push_back(static_cast<float>(deg_to_rad(100.0 - 1.2 * i)));
    scan.ranges_m.push_back(i == 4 ? 0.0F : 1.0F + 0.01F * static_cast<float>(i));
  }
  const LaserScan regular = make_regular(scan, 25.0F);
  ASSERT_EQ(regular.size(), 360U);
  EXPECT_TRUE(regular.bearings_rad.empty());
  int beams = 0;
  for (std::size_t bin = 0; bin < regular.size(); ++bin) {
    if (regular.ranges_m[bin] == 25.0F) continue;
    ++beams;
    const auto beam =
        static_cast<std::size_t>(std::lround((regular.ranges_m[bin] - 1.0F) * 100.0F));
    const double miss_rad = normalize_angle(regular.bearing_rad(bin) - scan.bearing_rad(beam));
    EXPECT_LE(std::abs(rad_to_deg(miss_rad)), 0.5 + 1e-4);  // half a step
  }
  EXPECT_EQ(beams, 299);  // 1.2 deg apart: no two in one place; one had no return
  LaserScan same;
  same.ranges_m = {1.0F, 2.0F};
  EXPECT_EQ(make_regular(same, 25.0F).ranges_m, same.ranges_m);
}

TEST(CarmenRoundTrip, OfARealLogGivesTheSameScans) {
  const char* data = std::getenv("MARCO_TEST_DATA");
  const std::string in = std::string(data == nullptr ? "" : data) + "/fr101/fr101.log";
  if (data == nullptr || !std::filesystem::exists(in)) {
    std::puts("SKIPPED: no CARMEN log in MARCO_TEST_DATA");
    return;
  }
  const ScratchFolder folder;
  import_file(in, folder / "one.lcm");
  export_log(folder / "one.lcm", folder);
  const auto before = scans_of(in), after = scans_of(folder / "out.log");
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].utime, after[i].utime);
    EXPECT_EQ(before[i].ranges_m, after[i].ranges_m);
    EXPECT_NEAR(before[i].first_bearing_rad, after[i].first_bearing_rad, 1e-6);
    EXPECT_NEAR(before[i].bearing_step_rad, after[i].bearing_step_rad, 1e-6);
  }
}

}  // namespace
}  // namespace marco::logs
