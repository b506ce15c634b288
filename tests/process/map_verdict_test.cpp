// marco-map's verdict on its own maps, and the lines that change the next one.
#include <gmock/gmock.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/files/tum.hpp"
#include "tests/support/command_test.hpp"
#include "tests/support/flat_world.hpp"

namespace marco {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr int kScans = 1200;
// A round takes 40 s. The second one is said to lie 1.5 m on from the first one.
constexpr const char* kWrongLoops =
    "add_loop 1001 1041 1.5 0 0\nadd_loop 1002 1042 1.5 0 0\nadd_loop 1003 1043 1.5 0 0\n"
    "add_loop 1004 1044 1.5 0 0\nadd_loop 1005 1045 1.5 0 0\nadd_loop 1006 1046 1.5 0 0\n"
    "add_loop 1007 1047 1.5 0 0\nadd_loop 1008 1048 1.5 0 0\nadd_loop 1009 1049 1.5 0 0\n"
    "add_loop 1010 1050 1.5 0 0\n";

class MapVerdict : public testing::CommandTest {
 protected:
  void SetUp() override { files::write_whole_file(at("rounds.log"), carmen_log()); }
  // Three times round a ring of rooms, a scan each 0.1 m or 9 degrees, ten a second; the odometry
  // is 2 % long.
  static std::string carmen_log() {
    testing::FlatWorld world;
    world.add_box(-7, -5, 7, 5);
    world.add_box(-4, -2, 4, 2);
    world.add_box(5.8, -0.5, 6.2, 0.1);
    world.add_box(-6.5, 3.0, -6.0, 3.6);
    world.add_box(1.0, -4.7, 2.1, -4.3);
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0.0, 0.01);
    std::string log;
    Pose2 robot{-5.5, -3.5, 0.0}, odom;
    const int sides[] = {110, 70, 110, 70};
    for (int i = 0, side = 0, on_side = 0; i < kScans; ++i) {
      log += "FLASER 180";
      for (int beam = 0; beam < 180; ++beam) {
        const double bearing_rad = robot.theta_rad + deg_to_rad(beam - 90.0);
        char text[20];
        std::snprintf(text, sizeof text, " %.3f",
                      world.range_m(robot.translation_m(), bearing_rad) + noise(random));
        log += text;
      }
      char text[200];
      std::snprintf(text, sizeof text, " %.4f %.4f %.5f %.4f %.4f %.5f %.6f host %.6f\n", odom.x_m,
                    odom.y_m, odom.theta_rad, odom.x_m, odom.y_m, odom.theta_rad, 1000.0 + 0.1 * i,
                    1000.0 + 0.1 * i);
      log += text;
      const bool turns = on_side >= sides[side];
      const Pose2 step = turns ? Pose2{0, 0, deg_to_rad(9)} : Pose2{0.1, 0, 0};
      robot = robot * step;
      odom = odom * Pose2{1.02 * step.x_m, 0.0, step.theta_rad};
      if (++on_side == sides[side] + 10) {
        on_side = 0;
        side = (side + 1) % 4;
      }
    }
    return log;
  }
  Result map(const std::string& edits) {
    files::write_whole_file(at("edits"), edits);
    return run("marco-map", {at("rounds.log"), "--out", at("out"), "--edits", at("edits")});
  }
  nlohmann::json report() const {
    return nlohmann::json::parse(files::read_whole_file(at("out") + "/report.json"));
  }
};

TEST_F(MapVerdict, ARightMapIsGoodAndItsRunEndsWithThat) {
  const Result result = map("");
  EXPECT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(result.output, EndsWith("\nverdict: good\n"));
  EXPECT_EQ(report()["verdict"], "good");
  EXPECT_TRUE(report()["doctor"]["reasons"].empty());
  EXPECT_FALSE(std::filesystem::exists(at("out") + "/doctor_1.png"));
  EXPECT_THAT(files::read_whole_file(at("out") + "/map.yaml"), Not(HasSubstr("verdict")));
}

TEST_F(MapVerdict, AWrongMapIsMarkedEverywhere) {
  const Result result = map(kWrongLoops);
  EXPECT_EQ(result.code, 3) << result.output;
  EXPECT_THAT(result.output, EndsWith("\nverdict: wrong\n"));
  EXPECT_EQ(report()["verdict"], "wrong");
  const nlohmann::json reason = report()["doctor"]["reasons"][0];
  EXPECT_EQ(reason["cause"], "contradiction");
  EXPECT_TRUE(std::filesystem::exists(at("out") + "/" + std::string(reason["picture"])));
  EXPECT_THAT(files::read_whole_file(at("out") + "/map.yaml"), StartsWith("# verdict: wrong"));
}

TEST_F(MapVerdict, CheckSaysTheSameAndWritesNothing) {
  files::write_whole_file(at("edits"), kWrongLoops);
  const Result result =
      run("marco-map", {"--check", at("rounds.log"), "--edits", at("edits"), "--out", at("out")});
  EXPECT_EQ(result.code, 3) << result.output;
  EXPECT_THAT(result.output, EndsWith("\nverdict: wrong\n"));
  EXPECT_FALSE(std::filesystem::exists(at("out")));
}

TEST_F(MapVerdict, ForbiddenLoopsAreNotClosed) {
  map("");
  const nlohmann::json loops = report()["loops"];
  ASSERT_FALSE(loops.empty());
  const int64_t from = loops[0]["from_utime"], to = loops[0]["to_utime"];
  char line[80];
  std::snprintf(line, sizeof line, "forbid_loop %lld.%06lld %lld.%06lld",
                static_cast<long long>(from / 1'000'000), static_cast<long long>(from % 1'000'000),
                static_cast<long long>(to / 1'000'000), static_cast<long long>(to % 1'000'000));
  EXPECT_EQ(map(line).code, 0);
  for (const nlohmann::json& loop : report()["loops"]) {
    const int64_t near_us = 5'000'000;
    EXPECT_FALSE(std::abs(loop["from_utime"].get<int64_t>() - from) <= near_us &&
                 std::abs(loop["to_utime"].get<int64_t>() - to) <= near_us);
  }
}

TEST_F(MapVerdict, DroppedScansGetNoPose) {
  EXPECT_EQ(map("drop_scans 1030 1031\n").code, 0);
  EXPECT_EQ(report()["scans"]["posed"], kScans - 11);
  for (const StampedPose2& pose : files::read_tum(at("out") + "/trajectory.tum")) {
    EXPECT_FALSE(pose.utime.us >= 1030'000'000 && pose.utime.us <= 1031'000'000);
  }
}

// Along the way the scans alone are as good; but not a digit is the same.
TEST_F(MapVerdict, DistrustedOdometryIsNotUsed) {
  map("");
  const std::string with = files::read_whole_file(at("out") + "/trajectory_live.tum");
  EXPECT_EQ(map("distrust_odometry 1000 2000\n").code, 0);
  EXPECT_NE(files::read_whole_file(at("out") + "/trajectory_live.tum"), with);
  EXPECT_EQ(report()["scans"]["matched"], kScans - 1);
}

TEST_F(MapVerdict, AFaultInTheEditsNamesFileAndLine) {
  const Result result = map("drop_scans 1 2\nforget_loop 1 2\n");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.output, HasSubstr(at("edits") + ", line 2: 'forget_loop'"));
}

}  // namespace
}  // namespace marco
