// marco-map's verdict on its own maps, and the lines that change the next one.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/files/tum.hpp"
#include "tests/support/command_test.hpp"
#include "tests/support/ring_log.hpp"

namespace marco {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// A round takes 40 s. The second one is said to lie 1.5 m on from the first one.
constexpr const char* kWrongLoops =
    "add_loop 1001 1041 1.5 0 0\nadd_loop 1002 1042 1.5 0 0\nadd_loop 1003 1043 1.5 0 0\n"
    "add_loop 1004 1044 1.5 0 0\nadd_loop 1005 1045 1.5 0 0\nadd_loop 1006 1046 1.5 0 0\n"
    "add_loop 1007 1047 1.5 0 0\nadd_loop 1008 1048 1.5 0 0\nadd_loop 1009 1049 1.5 0 0\n"
    "add_loop 1010 1050 1.5 0 0\n";

class MapVerdict : public testing::CommandTest {
 protected:
  void SetUp() override { files::write_whole_file(at("rounds.log"), testing::ring_log(1.02, 1.0)); }
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
  EXPECT_EQ(report()["scans"]["posed"], testing::kRingScans - 11);
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
  EXPECT_EQ(report()["scans"]["matched"], testing::kRingScans - 1);
}

TEST_F(MapVerdict, AFaultInTheEditsNamesFileAndLine) {
  const Result result = map("drop_scans 1 2\nforget_loop 1 2\n");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.output, HasSubstr(at("edits") + ", line 2: 'forget_loop'"));
}

}  // namespace
}  // namespace marco
