// marco-map finds out that a recording's set-up is not what it says, and maps it all the same.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "common/files/map_yaml.hpp"
#include "common/files/tum.hpp"
#include "tests/support/command_test.hpp"
#include "tests/support/ring_log.hpp"

namespace marco {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class MapSetUp : public testing::CommandTest {
 protected:
  Result map(double way_scale, double turn_scale, const std::vector<std::string>& more = {}) {
    files::write_whole_file(at("ring.log"), testing::ring_log(way_scale, turn_scale));
    std::vector<std::string> words{"marco-map", at("ring.log"), "--out", at("out")};
    words.insert(words.end(), more.begin(), more.end());
    return run(words.front(), {words.begin() + 1, words.end()});
  }
  nlohmann::json calibration() const {
    return nlohmann::json::parse(files::read_whole_file(at("out") + "/report.json"))
        .value("calibration", nlohmann::json());
  }
  double found(const std::string& name) const {
    const nlohmann::json all = calibration();
    for (const nlohmann::json& parameter : all["parameters"]) {
      if (parameter["name"] == name) return parameter.value("found", 0.0);
    }
    return 0.0;
  }
  // From the first scan to one a round later: the robot was in one place.
  double round_off_m() const {
    const Trajectory path = files::read_tum(at("out") + "/trajectory.tum");
    return between(path.at(50).world_from_robot, path.at(450).world_from_robot)
        .translation_m()
        .norm();
  }
};

TEST_F(MapSetUp, WheelsThatCountHalfOfTheWayAreFoundAndTheMapIsMadeAgain) {
  const Result result = map(0.5, 0.5);
  EXPECT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("set-up: "));
  EXPECT_THAT(result.output, HasSubstr("odometry.left_scale 1 -> "));
  EXPECT_THAT(result.output, HasSubstr("the map was made again"));
  EXPECT_EQ(calibration()["use"], "in_force");
  EXPECT_NEAR(found("odometry.left_scale"), 2.0, 0.02);
  EXPECT_NEAR(found("odometry.right_scale"), 2.0, 0.02);
  EXPECT_LT(round_off_m(), 0.03);
  EXPECT_FALSE(std::filesystem::exists(at("out") + "/corrected.part"));
  EXPECT_GT(std::filesystem::file_size(at("out") + "/slam.lcm"), 1000U);
}

TEST_F(MapSetUp, OdometryThatCountsBackwardsIsFound) {
  const Result result = map(-1.0, 1.0);
  EXPECT_EQ(calibration()["use"], "in_force") << result.output;
  EXPECT_EQ(found("odometry.forward_sign"), -1.0);
  EXPECT_LT(round_off_m(), 0.03);
}

TEST_F(MapSetUp, WhatTheFrontEndCopesWithIsSaidAndLeftAlone) {
  const Result result = map(1.04, 1.0);
  EXPECT_THAT(result.output, HasSubstr("odometry.left_scale 1 -> 0.96"));
  EXPECT_THAT(result.output, Not(HasSubstr("made again")));
  EXPECT_EQ(calibration()["use"], "not_needed");
}

// The largest distances [m] and angles [rad] of a path from odometry, which is exact here.
Eigen::Vector2d off_odometry(const std::string& folder) {
  const Trajectory path = files::read_tum(folder + "/trajectory.tum");
  const Trajectory odometry = files::read_tum(folder + "/odometry.tum");
  EXPECT_EQ(path.size(), odometry.size());
  Eigen::Vector2d most(0.0, 0.0);
  const Pose2 start = between(odometry.at(0).world_from_robot, path.at(0).world_from_robot);
  for (std::size_t i = 0; i < std::min(path.size(), odometry.size()); ++i) {
    const Pose2 moved = between(path[0].world_from_robot, path[i].world_from_robot);
    const Pose2 off =
        between(between(odometry[0].world_from_robot, odometry[i].world_from_robot), moved);
    most = most.cwiseMax(Eigen::Vector2d(off.translation_m().norm(), std::abs(off.theta_rad)));
  }
  EXPECT_LT(std::abs(start.theta_rad), deg_to_rad(1.0)) << "of the first pose";
  return most;
}

TEST_F(MapSetUp, ThePathOfATurnedLasersRobotIsTheRobots) {
  const Pose2 laser{0.3, -0.2, deg_to_rad(90.0)};
  files::write_whole_file(at("ring.log"), testing::ring_log(1.0, 1.0, 1.0, 1.0, laser));
  const Result result = run("marco-map", {at("ring.log"), "--calibrate", "--out", at("out")});
  EXPECT_EQ(result.code, 0) << result.output;
  EXPECT_EQ(calibration()["use"], "in_force") << result.output;
  EXPECT_LT(off_odometry(at("out")).x(), 0.05);
  EXPECT_LT(off_odometry(at("out")).y(), deg_to_rad(1.0));
  const auto report = nlohmann::json::parse(files::read_whole_file(at("out") + "/report.json"));
  EXPECT_EQ(report["path_of"], "robot");
  // With the file that the drive gave, found in its map, and by its own log: all the same.
  const auto same_path = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = more;
    words.insert(words.end(), {"--out", at("again")});
    const Result again = run("marco-map", words);
    EXPECT_EQ(again.code, 0) << again.output;
    EXPECT_LT(off_odometry(at("again")).x(), 0.05) << more.back() << again.output;
    EXPECT_LT(off_odometry(at("again")).y(), deg_to_rad(1.0)) << more.back();
    return again.output;
  };
  same_path({at("ring.log"), "--calibration", at("out") + "/calibration.toml"});
  same_path({at("ring.log"), "--localize", at("out")});
  EXPECT_THAT(same_path({at("out") + "/slam.lcm"}), Not(HasSubstr("laser.")));
}

// The log's first `scans`, odometry's places off by `sigma_m`.
std::string with_noisy_odometry(const std::string& log, int scans, double sigma_m) {
  std::istringstream lines(log);
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0.0, sigma_m);
  std::string text;
  for (std::string line; scans-- > 0 && std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    for (int i = 0; words >> word; ++i) {
      const bool place = i == 185 || i == 186;  // odom_x, odom_y
      text +=
          (i == 0 ? "" : " ") + (place ? std::to_string(std::stod(word) + noise(random)) : word);
    }
    text += "\n";
  }
  return text;
}

TEST_F(MapSetUp, ATurnThatIsInDoubtGivesBothPaths) {
  const std::string turned = testing::ring_log(1.0, 1.0, 1.0, 1.0, {0.0, 0.0, deg_to_rad(90.0)});
  files::write_whole_file(at("ring.log"), with_noisy_odometry(turned, 400, 0.18));
  const Result result = run("marco-map", {at("ring.log"), "--out", at("out")});
  EXPECT_THAT(result.output, HasSubstr("trajectory_as_found.tum is the path"));
  EXPECT_THAT(result.output, HasSubstr("verdict: doubtful"));
  EXPECT_EQ(calibration().value("path_as_found", ""), "trajectory_as_found.tum");
  const Trajectory as_said = files::read_tum(at("out") + "/trajectory.tum");
  const Trajectory as_found = files::read_tum(at("out") + "/trajectory_as_found.tum");
  ASSERT_EQ(as_said.size(), as_found.size());
  // The first side is 11 m straight ahead; the laser looks to its left.
  const Pose2 by_said = between(as_said.at(0).world_from_robot, as_said.at(100).world_from_robot);
  const Pose2 by_found =
      between(as_found.at(0).world_from_robot, as_found.at(100).world_from_robot);
  EXPECT_NEAR(by_said.y_m, -10.0, 0.2);
  EXPECT_NEAR(by_found.x_m, 10.0, 1.0);
}

TEST_F(MapSetUp, WithoutOdometryThePathIsTheLasers) {
  map(0.0, 0.0, {"--no-calibration"});
  const auto report = nlohmann::json::parse(files::read_whole_file(at("out") + "/report.json"));
  EXPECT_EQ(report["path_of"], "laser");
}

// Of each scan 25 beams: of a mast 0.25 m ahead of the laser on its left.
std::string with_a_mast(const std::string& log) {
  std::istringstream lines(log);
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0.25, 0.005);
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    for (int i = 0; words >> word; ++i) {
      const bool mast = i >= 2 + 110 && i < 2 + 135;
      text += (i == 0 ? "" : " ") + (mast ? std::to_string(noise(random)) : word);
    }
    text += "\n";
  }
  return text;
}

TEST_F(MapSetUp, TheRobotInItsOwnViewIsLeftOut) {
  files::write_whole_file(at("ring.log"), with_a_mast(testing::ring_log(1.0, 1.0)));
  const Result result = run("marco-map", {at("ring.log"), "--calibrate", "--out", at("out")});
  EXPECT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("set-up: the robot itself is in view of LIDAR"));
  const auto report = nlohmann::json::parse(files::read_whole_file(at("out") + "/report.json"));
  ASSERT_EQ(report["own_body"].size(), 1U);
  EXPECT_NEAR(report["own_body"][0]["first_deg"], 20.0, 1.5);
  EXPECT_NEAR(report["own_body"][0]["last_deg"], 45.0, 1.5);
  EXPECT_LT(round_off_m(), 0.03);
  // Found from the first scan on: no trace of it is in the map.
  const GridMap map = files::read_map(at("out") + "/map.yaml");
  const Eigen::Vector2i cell = map.cell_of({0.21, 0.13});
  EXPECT_LT(map.at(cell.x(), cell.y()), 50);
  EXPECT_THAT(files::read_whole_file(at("out") + "/calibration.toml"), HasSubstr("[[body]]"));
}

// The floor ahead of a laser that looks down, along a line 2.5 m from it.
std::string with_the_floor(const std::string& log) {
  std::istringstream lines(log);
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    for (int i = 0; words >> word; ++i) {
      const int beam = i - 2;
      if (beam > 0 && beam < 180) {
        const double floor_m = 2.5 / std::cos(deg_to_rad(beam - 90.0));
        if (std::stod(word) > floor_m) word = std::to_string(floor_m + noise(random));
      }
      text += (i == 0 ? "" : " ") + word;
    }
    text += "\n";
  }
  return text;
}

TEST_F(MapSetUp, TheFloorInViewOfALaserThatIsNotLevelIsLeftOut) {
  files::write_whole_file(at("ring.log"), with_the_floor(testing::ring_log(1.0, 1.0)));
  const Result result = run("marco-map", {at("ring.log"), "--calibrate", "--out", at("out")});
  EXPECT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("set-up: LIDAR is not level"));
  const auto report = nlohmann::json::parse(files::read_whole_file(at("out") + "/report.json"));
  ASSERT_EQ(report["floor"].size(), 1U);
  EXPECT_NEAR(report["floor"][0]["bearing_deg"], 0.0, 2.5);
  EXPECT_GT(report["floor"][0]["from_m"], 2.25);
  EXPECT_LT(report["floor"][0]["from_m"], 2.48);
  EXPECT_LT(round_off_m(), 0.03);
  EXPECT_THAT(files::read_whole_file(at("out") + "/calibration.toml"), HasSubstr("[[floor]]"));
}

// Two recorders' logs, merged.
TEST_F(MapSetUp, ScansThatCameTwiceAreUsedOnce) {
  std::istringstream lines(testing::ring_log(1.0, 1.0));
  std::string twice;
  for (std::string line; std::getline(lines, line);) twice += line + "\n" + line + "\n";
  files::write_whole_file(at("ring.log"), twice);
  const Result result = run("marco-map", {at("ring.log"), "--out", at("out")});
  EXPECT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("duplicate scan " + std::to_string(testing::kRingScans)));
  EXPECT_EQ(files::read_tum(at("out") + "/trajectory.tum").size(),
            static_cast<std::size_t>(testing::kRingScans));
  EXPECT_LT(round_off_m(), 0.03);
}

TEST_F(MapSetUp, BearingsThatAreTooNarrowAreFoundAndTheMapIsMadeAgain) {
  files::write_whole_file(at("ring.log"), testing::ring_log(1.0, 1.0, 1.0, 1.03));
  const Result result = run("marco-map", {at("ring.log"), "--calibrate", "--out", at("out")});
  EXPECT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("beams.bearing_scale 1 -> 1.0"));
  EXPECT_EQ(calibration()["use"], "in_force");
  EXPECT_NEAR(found("beams.bearing_scale"), 1.03, 0.003);
  EXPECT_LT(round_off_m(), 0.03);
  const std::string written = files::read_whole_file(at("out") + "/calibration.toml");
  EXPECT_THAT(written, HasSubstr("[[beams]]"));
  EXPECT_THAT(written, HasSubstr("bearing_scale = 1.0"));
}

TEST_F(MapSetUp, RightBeamsAreSaidToBeSo) {
  const Result result = map(1.0, 1.0);
  EXPECT_THAT(result.output, Not(HasSubstr("beams."))) << result.output;
  EXPECT_NEAR(found("beams.bearing_scale"), 1.0, 0.003);
}

TEST_F(MapSetUp, OdometryWithItsHeadingInDegreesIsLeftOutFromTheFirstScanOn) {
  files::write_whole_file(at("ring.log"), testing::ring_log(1.0, 1.0, rad_to_deg(1.0)));
  const Result result = run("marco-map", {at("ring.log"), "--out", at("out")});
  EXPECT_THAT(result.output, HasSubstr("is its heading in degrees?")) << result.output;
  EXPECT_FALSE(std::filesystem::exists(at("out") + "/odometry.tum"));
  EXPECT_LT(round_off_m(), 0.03);
}

TEST_F(MapSetUp, NobodyLooksWhereNobodyShall) {
  const Result result = map(0.5, 0.5, {"--no-calibration"});
  EXPECT_THAT(result.output, Not(HasSubstr("set-up")));
  EXPECT_TRUE(calibration().is_null());
}

}  // namespace
}  // namespace marco
