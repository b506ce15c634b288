// Text logs, the theses' files, tilted 3D scans, and telling them apart.
#include <gmock/gmock.h>

#include <unistd.h>

#include <cmath>
#include <sstream>

#include "common/files/text_fields.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/recording.hpp"
#include "recordings/text_formats.hpp"
#include "recordings/tilted_scans.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/recorded.hpp"

namespace marco::files {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::marco::testing::read_all;
using ::marco::testing::Recorded;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

TEST(OdometryLaserText, LinesBecomeScansATenthOfASecondApart) {
  const TemporaryFolder folder;
  const auto path =
      folder.write("log", "Odometry 1 2 0.5\nLaser 3 1 2 3\nOdometry 1.5 2 0.5\nLaser 3 1 2 4\n");
  const Recorded recorded = read_all(*open_odometry_laser_text(path));
  ASSERT_EQ(recorded.scans.size(), 2U);
  EXPECT_NEAR((recorded.scans[1].utime - recorded.scans[0].utime).seconds(), 0.1, 1e-9);
  EXPECT_NEAR(recorded.scans[0].bearing_rad(1), 0.0, 1e-12);
  EXPECT_THAT(recorded.odometry.at(1).odom_from_robot, IsNear(Pose2{1.5, 2, 0.5}, 1e-12, 1e-12));
  EXPECT_THAT(recorded.report.notes,
              ::testing::ElementsAre(HasSubstr("80.000 m"), HasSubstr("0.1 s")));
}

// As a SICK in its range of 8 m gives it, by two codes; walls end before.
TEST(OdometryLaserText, ThePileAtTheTopIsNoReturn) {
  const TemporaryFolder folder;
  std::string lines;
  for (int scan = 0; scan < 40; ++scan) {
    lines += "Laser 12 8.18 8.19";
    for (int beam = 0; beam < 10; ++beam) lines += " " + std::to_string(1.0 + 0.013 * scan * beam);
    lines += "\n";
  }
  const Recorded recorded = read_all(*open_odometry_laser_text(folder.write("log", lines)));
  EXPECT_GT(recorded.infos.at(0).range_max_m, 7.9);
  EXPECT_LT(recorded.infos.at(0).range_max_m, 8.18);
}

TEST(OdometryLaserText, LinesThatCannotBeReadAreCountedWithTheirPlace) {
  const TemporaryFolder folder;
  const auto path = folder.write(
      "log", "Odometry 1 2 0.5\nOdometry 1 nan 0\nLaser 3 1 2\nLaser 1 1\nLaser 2 1 2\n");
  const Recorded recorded = read_all(*open_odometry_laser_text(path));
  EXPECT_EQ(recorded.scans.size(), 1U);
  EXPECT_THAT(recorded.odometry.at(0).odom_from_robot, IsNear(Pose2{1, 2, 0.5}, 1e-12, 1e-12));
  using ::testing::Pair;
  EXPECT_THAT(recorded.report.places,
              ::testing::UnorderedElementsAre(Pair("unreadable odometry line", "line 2"),
                                              Pair("unreadable laser line", "line 3"),
                                              Pair("scan of fewer than 2 beams", "line 4")));
}

std::string thesis_a_scan(double x_cm) {
  std::string text;
  for (int i = 0; i < 133; ++i) {
    const double bearing = deg_to_rad(-95.0 + i * 190.0 / 132.0);
    text += std::to_string(2.0 * std::cos(bearing)) + " " +
            std::to_string(2.0 * std::sin(bearing)) + "\n";
  }
  return text + std::to_string(x_cm) + " -50 0.25\n";
}

TEST(ThesisFiles, ScansOfThesisAAreInMetresAndTheirOdometryInCentimetres) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.txt", thesis_a_scan(100) + thesis_a_scan(150));
  ASSERT_TRUE(is_thesis_file(path));
  const Recorded recorded = read_all(*open_thesis_file(path));
  ASSERT_EQ(recorded.scans.size(), 2U);
  EXPECT_EQ(recorded.scans[0].size(), 133U);
  for (const float range_m : recorded.scans[0].ranges_m) EXPECT_NEAR(range_m, 2.0, 1e-5);
  EXPECT_THAT(recorded.odometry.at(1).odom_from_robot, IsNear(Pose2{1.5, -0.5, 0.25}, 1e-9, 1e-9));
}

std::string thesis_b_sweep(double range_mm, double tilt_deg, double moved_mm) {
  std::string text;
  for (int i = 0; i < 361; ++i) {
    text += std::to_string(0.5 * i) + " " + std::to_string(range_mm) + "\n";
  }
  return text + std::to_string(moved_mm) + " 90 " + std::to_string(tilt_deg) + " 0\n";
}

TEST(ThesisFiles, SweepsOfThesisBAreInMillimetresAndARepeatedEndIsDropped) {
  const TemporaryFolder folder;
  const auto path =
      folder.write("b.txt", thesis_b_sweep(1000, 0, 0) + thesis_b_sweep(2000, 0, 500) +
                                thesis_b_sweep(2000, 0, 500));
  const Recorded recorded = read_all(*open_thesis_file(path));
  ASSERT_EQ(recorded.scans.size(), 2U);
  EXPECT_FLOAT_EQ(recorded.scans[0].ranges_m[0], 1.0F);
  EXPECT_FLOAT_EQ(recorded.scans[1].ranges_m[360], 2.0F);
  const Pose2 moved =
      between(recorded.odometry.at(0).odom_from_robot, recorded.odometry.at(1).odom_from_robot);
  EXPECT_NEAR(moved.translation_m().norm(), 0.5, 1e-6);
  EXPECT_NEAR(std::abs(moved.theta_rad), deg_to_rad(90), 1e-6);
}

TEST(TiltedScans, RowsOfMillimetresBecomeATiltAndAScanEach) {
  const TemporaryFolder folder;
  const auto row = [](const std::string& tilt_deg, int last_mm) {
    std::string text = tilt_deg;
    for (int i = 0; i < 359; ++i) text += "," + std::to_string(1000 + i);
    return text + "," + std::to_string(last_mm) + "\n";
  };
  folder.write("scan000_tilt_ranges_mm.csv", row("-10.0", 5000) + row("5.5", 32767));
  const Recorded recorded = read_all(*open_tilted_scans({folder.path()}));
  ASSERT_EQ(recorded.scans.size(), 2U);
  ASSERT_GE(recorded.pantilt.size(), 2U);
  EXPECT_FLOAT_EQ(recorded.scans[0].ranges_m[1], 1.001F);
  EXPECT_NEAR(recorded.scans[0].bearing_rad(180), 0.0, 1e-9);
  EXPECT_NEAR(recorded.scans[0].bearing_step_rad, deg_to_rad(0.5), 1e-9);
  // The device's code for nothing must not survive as a wall 32.767 m away.
  const float code = recorded.scans[1].ranges_m[359];
  EXPECT_TRUE(code == 0.0F || static_cast<double>(code) >= recorded.infos.back().range_max_m);
}

// The count of samples that a report gives is the count that a reader hands out, and progress ends
// at 1; of every format.
TEST(Readers, ReportsAndProgressAreTrueOfEveryFormat) {
  const TemporaryFolder folder;
  std::string row = "10.0";
  for (int i = 0; i < 60; ++i) row += ",1000";
  for (const auto& path : {folder.write("carmen", "FLASER 2 1 2 0 0 0 0 0 0 5.0 h 1\nODOM 1\n"),
                           folder.write("text", "Odometry 1 2 0.5\nLaser 3 1 2 3\n"),
                           folder.write("thesis", thesis_a_scan(0)),
                           folder.write("a_tilt_ranges_mm.csv", row + "\n")}) {
    const auto reader = open_recording(path);
    EXPECT_LT(reader->progress(), 1.0) << path;
    Recorded recorded = read_all(*reader);
    EXPECT_EQ(recorded.report.given.at("scans"), 1) << path;
    EXPECT_EQ(recorded.scans.size(), 1U) << path;
    EXPECT_EQ(recorded.odometry.size(), 1U) << path;
    EXPECT_EQ(recorded.report.paths, std::vector<std::string>{path.string()});
    EXPECT_EQ(reader->progress(), 1.0) << path;
    const std::size_t notes = recorded.report.notes.size();
    EXPECT_FALSE(reader->next());  // the end stays the end, and is reported once
    EXPECT_EQ(reader->report().notes.size(), notes) << path;
  }
}

TEST(TiltedScans, PointsOfUosBecomeRowsFromTheRightOn) {
  const TemporaryFolder folder;
  // Left-handed, x to the right, y up, z ahead [cm]: two rows of three beams, level and 45 deg up.
  const auto path = folder.write(
      "scan000.3d", "100 0 0\n0 0 200\n-300 0 0\n100 0 0.001\n0 100 100\n-100 0 0.001\nrubbish\n");
  folder.write("scan000.pose", "100 0 300\n0 -90 0\n");
  const Recorded recorded = read_all(*open_tilted_scans({path}));
  ASSERT_EQ(recorded.scans.size(), 2U);
  EXPECT_THAT(recorded.scans[0].ranges_m, ::testing::ElementsAre(1.0F, 2.0F, 3.0F));
  EXPECT_NEAR(recorded.scans[0].bearing_rad(0), deg_to_rad(-90), 1e-6);
  EXPECT_NEAR(recorded.scans[0].bearing_rad(2), deg_to_rad(90), 1e-6);
  EXPECT_NEAR(recorded.pantilt.at(0).tilt_rad, 0.0, 1e-6);
  EXPECT_NEAR(recorded.pantilt.at(1).tilt_rad, deg_to_rad(45), 1e-4);
  EXPECT_THAT(recorded.odometry.at(0).odom_from_robot,
              IsNear(Pose2{3.0, -1.0, deg_to_rad(90)}, 1e-9, 1e-9));
  EXPECT_EQ(recorded.report.places.at("unreadable point"), path.string() + ":7");
}

TEST(TiltedScans, PolarLinesLieOnOneGridAndAMissingBeamHasNoReturn) {
  const TemporaryFolder folder;
  const auto path = folder.write("scan_polar.csv",
                                 "# line,tilt_deg,bearing_deg,range_m\n"
                                 "0,-5,-89.75,1.5\n0,-5,-87.75,2.5\n1,0,-89.5,3.5\n1,0,200,9\n");
  const Recorded recorded = read_all(*open_tilted_scans({path}));
  ASSERT_EQ(recorded.scans.size(), 2U);
  EXPECT_THAT(recorded.scans[0].ranges_m, ::testing::ElementsAre(1.5F, 0.0F, 2.5F));
  EXPECT_THAT(recorded.scans[1].ranges_m, ::testing::ElementsAre(3.5F, 0.0F, 0.0F));
  EXPECT_NEAR(recorded.scans[0].bearing_rad(0), deg_to_rad(-89.75), 1e-9);
  EXPECT_NEAR(recorded.scans[1].bearing_rad(0), deg_to_rad(-89.5), 1e-9);
  EXPECT_NEAR(recorded.infos.at(0).parent_from_sensor.translation().z(), 0.340, 1e-12);
  EXPECT_EQ(recorded.report.places.at("unreadable point"), path.string() + ":5");
}

TEST(OpenRecording, TellsKindsApartByContentWhateverTheName) {
  const TemporaryFolder folder;
  const auto carmen = folder.write("a.lcm", "FLASER 2 1 2 0 0 0 0 0 0 5.0 h 1\n");
  EXPECT_EQ(open_recording(carmen)->report().format, "CARMEN log");
  const auto text = folder.write("b.png", "Odometry 1 2 0.5\nLaser 3 1 2 3\n");
  EXPECT_THAT(open_recording(text)->report().format, HasSubstr("Odometry"));
  const auto thesis = folder.write("c.log", thesis_a_scan(0));
  EXPECT_EQ(open_recording(thesis)->report().format, "thesis A scans");
  const auto points = folder.write("d.3d", "0 0 100\n-100 0 0\n");
  EXPECT_EQ(open_recording(points)->report().format, "3D scans of a tilted laser");
  // What is not text is not given to the readers of numbers.
  const auto binary = folder.write("e.3d", std::string("0 0 100\n\0\n", 10));
  EXPECT_THAT(complaint([&] { open_recording(binary); }), HasSubstr("binary data"));
}

// Nobody's rights: root's may read everything.
class Nobody {
 public:
  Nobody() : was_root_(geteuid() == 0) {
    if (was_root_) {
      EXPECT_EQ(seteuid(65534), 0);
    }
  }
  ~Nobody() {
    if (was_root_) {
      EXPECT_EQ(seteuid(0), 0);
    }
  }
  Nobody(const Nobody&) = delete;
  Nobody& operator=(const Nobody&) = delete;

 private:
  bool was_root_;
};

TEST(OpenRecording, AForbiddenFileIsCalledSo) {
  const TemporaryFolder folder;
  const auto file = folder.write("a.log", "FLASER 2 1 2 0 0 0 0 0 0 5.0 h 1\n");
  const auto inner = folder.path() / "closed";
  std::filesystem::create_directory(inner);
  const auto within = folder.write("closed/b.log", "x");
  using std::filesystem::perms;
  std::filesystem::permissions(file, perms::none);
  std::filesystem::permissions(inner, perms::none);
  std::string forbidden, by_folder, whole, log;
  {
    const Nobody nobody;
    forbidden = complaint([&] { open_recording(file); });
    by_folder = complaint([&] { open_recording(within); });
    whole = complaint([&] { files::read_whole_file(file); });
    log = complaint([&] { files::EventLogReader reader(file.string()); });
  }
  std::filesystem::permissions(inner, perms::owner_all);
  for (const std::string& text : {forbidden, whole, log}) {
    EXPECT_THAT(text, HasSubstr("permission denied to"));
    EXPECT_THAT(text, HasSubstr("a.log"));
    EXPECT_THAT(text, HasSubstr("chmod +r"));
  }
  EXPECT_THAT(by_folder, HasSubstr("by a parent folder"));
}

TEST(OpenRecording, SaysWhatIsWrongWithWhatItCannotRead) {
  const TemporaryFolder folder;
  const auto says = [&](const std::filesystem::path& path) {
    return complaint([&] { open_recording(path); });
  };
  EXPECT_THAT(says(folder.path() / "absent"), HasSubstr("no such file"));
  EXPECT_THAT(says(folder.write("empty", "")), HasSubstr("empty"));
  EXPECT_THAT(says(folder.write("p", "\x89PNG\r\n\x1a\n....")), HasSubstr("PNG picture"));
  EXPECT_THAT(says(folder.write("prose", "Dear robot, how are you today?")),
              HasSubstr("known inputs"));
  EXPECT_THAT(says(folder.path()), HasSubstr("no 3D scan"));
}

TEST(ReadLine, LinesHaveABound) {
  std::istringstream text("a\n\n" + std::string(5 << 20, 'x') + "\nlast");
  std::string line;
  ASSERT_TRUE(read_line(text, line));
  EXPECT_EQ(line, "a");
  ASSERT_TRUE(read_line(text, line));
  EXPECT_EQ(line, "");
  ASSERT_TRUE(read_line(text, line));
  EXPECT_EQ(line.size(), 4U << 20U);
  ASSERT_TRUE(read_line(text, line));
  EXPECT_EQ(line.size(), 1U << 20U);
  ASSERT_TRUE(read_line(text, line));
  EXPECT_TRUE(line == "last");
  EXPECT_FALSE(read_line(text, line));
}

}  // namespace
}  // namespace marco::files
