#include "recordings/text_formats.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/recorded.hpp"

namespace marco::files {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::marco::testing::read_all;
using ::marco::testing::Recorded;
using ::marco::testing::TemporaryFolder;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Recorded read(const std::string& text) {
  const TemporaryFolder folder;
  return read_all(*open_carmen(folder.write("any.name", text)));
}

TEST(Carmen, OldLaserLineGivesOdometryThenTheScan) {
  const Recorded recorded = read(
      "# comment\nPARAM robot x\n"
      "FLASER 4 1.0 2.0 3.0 4.0 0.5 0.25 1.5 0.5 0.25 1.5 12.25 host 13.0\n");
  ASSERT_EQ(recorded.scans.size(), 1U);
  const LaserScan& scan = recorded.scans[0];
  EXPECT_EQ(scan.utime, Utime::from_us(12250000));
  EXPECT_THAT(scan.ranges_m, ElementsAre(1.0F, 2.0F, 3.0F, 4.0F));
  // Half a circle; an even count leaves its last beam out.
  EXPECT_NEAR(scan.bearing_rad(0), deg_to_rad(-90), 1e-12);
  EXPECT_NEAR(scan.bearing_rad(2), 0.0, 1e-12);
  ASSERT_EQ(recorded.odometry.size(), 1U);
  EXPECT_THAT(recorded.odometry[0].odom_from_robot, IsNear(Pose2{0.5, 0.25, 1.5}, 1e-12, 1e-12));
  EXPECT_EQ(recorded.odometry[0].utime, scan.utime);
  ASSERT_EQ(recorded.infos.size(), 1U);
}

TEST(Carmen, AnOddCountIncludesBothEnds) {
  const Recorded recorded = read("FLASER 5 1 1 1 1 1 0 0 0 0 0 0 1.0 h 1.0\n");
  EXPECT_NEAR(recorded.scans.at(0).bearing_rad(4), deg_to_rad(90), 1e-12);
}

TEST(Carmen, NewLaserLineSaysItsOwnGeometryAndMounting) {
  const Recorded recorded = read(
      "ROBOTLASER1 0 -1.0 2.0 0.5 20.0 0.01 0 3 1.0 2.0 3.0 0 "
      "1.1 2.0 0.0 1.0 2.0 0.0 0.1 0.2 0.3 0.4 0.5 77.5 host 77.6\n");
  ASSERT_EQ(recorded.scans.size(), 1U);
  EXPECT_DOUBLE_EQ(recorded.scans[0].bearing_rad(0), -1.0);
  EXPECT_DOUBLE_EQ(recorded.scans[0].bearing_rad(2), 0.0);
  EXPECT_EQ(recorded.scans[0].utime, Utime::from_us(77500000));
  ASSERT_EQ(recorded.infos.size(), 1U);
  EXPECT_DOUBLE_EQ(recorded.infos[0].range_max_m, 20.0);
  EXPECT_NEAR(recorded.infos[0].parent_from_sensor.translation().x(), 0.1, 1e-12);
}

TEST(Carmen, TheRearLaserHasItsOwnChannelAndLooksBack) {
  const Recorded recorded = read(
      "FLASER 3 1 2 3 0 0 0 0 0 0 1.0 h 1\n"
      "RLASER 3 4 5 6 0 0 0 0 0 0 1.1 h 1\n"
      "ROBOTLASER2 0 -1.0 2.0 0.5 20.0 0.01 0 3 7 8 9 0 "
      "0.9 2.0 3.0 1.0 2.0 0.0 0 0 0 0 0 1.2 host 1\n");
  ASSERT_EQ(recorded.scans.size(), 3U);
  EXPECT_EQ(recorded.scans[0].channel, "LIDAR");
  EXPECT_EQ(recorded.scans[1].channel, "LIDAR_REAR");
  EXPECT_EQ(recorded.scans[2].channel, "LIDAR_REAR");
  ASSERT_EQ(recorded.infos.size(), 2U);
  EXPECT_EQ(recorded.infos[0].channel, "LIDAR");
  EXPECT_TRUE(recorded.infos[0].parent_from_sensor.isApprox(Pose3::Identity()));
  EXPECT_EQ(recorded.infos[1].channel, "LIDAR_REAR");
  EXPECT_THAT(flatten(recorded.infos[1].parent_from_sensor),
              IsNear(Pose2{0, 0, deg_to_rad(180)}, 1e-12, 1e-12));
}

TEST(Carmen, TheScanDurationFollowsTheBeamSpacing) {
  const auto duration_s = [](int beams) {
    std::string text = "FLASER " + std::to_string(beams);
    for (int i = 0; i < beams; ++i) text += " 1.5";
    return read(text + " 0 0 0 0 0 0 1.0 h 1\n").infos.at(0).scan_duration_s;
  };
  EXPECT_DOUBLE_EQ(duration_s(180), 0.00667);  // whole degrees: half a turn of the mirror
  EXPECT_DOUBLE_EQ(duration_s(361), 0.02);     // half degrees
  EXPECT_DOUBLE_EQ(duration_s(401), 0.02);     // quarter degrees over 100
}

TEST(Carmen, The401BeamsOfALongRangeLaserCover100Degrees) {
  std::string text = "FLASER 401";
  for (int i = 0; i < 401; ++i) text += " 1.5";
  const Recorded recorded = read(text + " 0 0 0 0 0 0 1.0 h 1\n");
  EXPECT_NEAR(recorded.scans.at(0).bearing_rad(0), deg_to_rad(-50), 1e-12);
  EXPECT_NEAR(recorded.scans.at(0).bearing_rad(400), deg_to_rad(50), 1e-12);
}

TEST(Carmen, TheRangeThatComesAgainAndAgainMeansNoReturn) {
  std::string text;
  for (int i = 0; i < 30; ++i)
    text += "FLASER 3 1.0 81.83 2.0 0 0 0 0 0 0 " + std::to_string(i) + ".0 h 1\n";
  const Recorded recorded = read(text);
  EXPECT_LT(recorded.infos.at(0).range_max_m, 81.83);
  EXPECT_GT(recorded.infos.at(0).range_max_m, 75.0);
  EXPECT_THAT(recorded.report.notes.at(0), HasSubstr("no return"));
}

TEST(Carmen, DamagedLinesAreCountedWithTheirPlaceAndTheRestIsUsed) {
  const Recorded recorded = read(
      "FLASER 3 1 2\n"                             // cut
      "FLASER -4 1 2 3 0 0 0 0 0 0 1.0 h 1\n"      // count
      "FLASER 0 0 0 0 0 0 0 1.0 h 1\n"             // nothing in it
      "FLASER 3 nan inf -1 0 0 0 0 0 0 2.0 h 1\n"  // ranges a device sends
      "FLASER 3 1 2 3 0 0 0 nan 0 0 3.0 h 1\n"     // no place
      "FLASER 3 1 2 3 0 0 0 0 0 0 4.0 h 1\n");
  EXPECT_EQ(recorded.scans.size(), 2U);
  EXPECT_EQ(recorded.report.dropped.at("unreadable laser line"), 3);
  EXPECT_EQ(recorded.report.places.at("unreadable laser line"), "line 1");
  EXPECT_EQ(recorded.report.dropped.at("scan of fewer than 2 beams"), 1);
}

TEST(Carmen, StampsThatStepBackAreKeptInFileOrderAndTold) {
  const Recorded recorded = read(
      "FLASER 2 1 2 0 0 0 0 0 0 5.0 h 1\nFLASER 2 1 2 0 0 0 0 0 0 4.5 h 1\nODOM 0 0 0 0 0 0 5 h "
      "1\n");
  ASSERT_EQ(recorded.scans.size(), 2U);
  EXPECT_EQ(recorded.scans[1].utime, Utime::from_us(4500000));
  EXPECT_THAT(recorded.report.notes, ::testing::Contains(HasSubstr("1 stamps step backwards")));
}

TEST(Carmen, AFileWithoutLaserLinesIsRefusedByName) {
  EXPECT_THAT(complaint([] { read("ODOM 0 0 0 0 0 0 5 h 1\n"); }),
              HasSubstr("no readable laser line"));
}

// A line a second, or as far apart as that.
std::string scans_every(double step_s, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += "FLASER 4 1.0 2.0 3.0 4.0 0 0 0 0 0 0 " + std::to_string(1e6 + step_s * i) + " h 0\n";
  }
  return text;
}

TEST(Carmen, StampsThatAreNoTimesAreNotedWithTheirCount) {
  const auto notes = [](double step_s) { return read(scans_every(step_s, 20)).report.notes; };
  EXPECT_THAT(notes(0.0),
              Contains("19 of 20 scans have the stamp of the previous one: their stamps "
                       "are not measurement times"));
  EXPECT_THAT(notes(3.15e7), Contains("19 of 20 scans are an hour or more from the previous one: "
                                      "their stamps are not measurement times"));
  EXPECT_THAT(notes(-4000.0), Contains(HasSubstr("19 of 20 scans are an hour or more")));
  EXPECT_THAT(notes(1.0), Not(Contains(HasSubstr("not measurement times"))));
}

// As after a power cut, and larger than could be read in an hour.
TEST(Carmen, GoesOnBehindAHole) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.log", scans_every(1.0, 3));
  std::filesystem::resize_file(path, uint64_t{200} << 30U);
  std::ofstream(path, std::ios::app) << "\n" << scans_every(1.0, 4);
  EXPECT_EQ(read_all(*open_carmen(path)).scans.size(), 7U);
}

}  // namespace
}  // namespace marco::files
