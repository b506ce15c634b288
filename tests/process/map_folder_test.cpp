// The folder of marco-map's results: a run that fails changes nothing in it.
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <thread>

#include "common/files/tum.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "tests/support/command_test.hpp"

namespace marco {
namespace {

using ::marco::testing::Program;
using ::testing::HasSubstr;

// Results of an earlier run, with a file of the user's among them.
class MapFolder : public testing::CommandTest {
 protected:
  MapFolder() {
    EXPECT_EQ(run("marco-map", {"logs/sample.lcm", "--out", at("out")}).code, 0);
    std::ofstream(at("out/note.txt")) << "mine";
    good_ = content();
  }
  std::map<std::string, std::string> content() const {
    std::map<std::string, std::string> content;
    for (const auto& entry : std::filesystem::directory_iterator(at("out"))) {
      content[entry.path().filename().string()] = files::read_whole_file(entry.path());
    }
    return content;
  }
  void expect_untouched(const Result& result, const std::string& message) const {
    EXPECT_EQ(result.code, 1) << result.output;
    EXPECT_THAT(result.output, HasSubstr(message));
    EXPECT_TRUE(content() == good_) << message;
    EXPECT_FALSE(std::filesystem::exists(at("out.part")));
  }
  std::map<std::string, std::string> good_;
};

// A CARMEN log of a round hall, 14 m across: no room of the sample's.
std::string hall() {
  std::string log;
  for (int i = 0; i < 40; ++i) {
    const double x_m = 0.05 * i;
    log += "FLASER 181";
    for (int beam = 0; beam < 181; ++beam) {
      const double bearing_rad = deg_to_rad(beam - 90.0), along = x_m * std::cos(bearing_rad);
      log += " " + std::to_string(-along + std::sqrt(along * along + 49.0 - x_m * x_m));
    }
    const std::string pose = " " + std::to_string(x_m) + " 0 0";
    log += pose + pose + " " + std::to_string(0.1 * i) + " host " + std::to_string(0.1 * i) + "\n";
  }
  return log;
}

TEST_F(MapFolder, ALogInItIsMappedIntoIt) {
  const std::string log = good_.at("slam.lcm"), path = good_.at("trajectory.tum");
  const Result result = run("marco-map", {at("out/slam.lcm"), "--out", at("out")});
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_GT(files::read_whole_file(at("out/slam.lcm")).size(), log.size() / 2);
  EXPECT_EQ(files::read_tum(at("out/trajectory.tum")).size(),
            static_cast<std::size_t>(std::count(path.begin(), path.end(), '\n')));
  EXPECT_EQ(files::read_whole_file(at("out/note.txt")), "mine");
}

TEST_F(MapFolder, WhatCannotBeMappedLeavesItAsItWas) {
  const auto map = [&](const std::string& input) {
    return run("marco-map", {input, "--out", at("out")});
  };
  expect_untouched(map(folder_.write("junk", std::string(100000, '\0')).string()), "binary data");
  expect_untouched(map("/nonexistent.log"), "no such file");
  {
    files::EventLogWriter log(at("no_scans.lcm"));
    log.write("NOISE", std::vector<uint8_t>(100), Utime::from_us(1));
  }
  expect_untouched(map(at("no_scans.lcm")), "no laser among its channels");
}

TEST_F(MapFolder, CtrlCLeavesItAsItWas) {
  Program map("marco-map", {"logs/sample.lcm", "logs/sample.lcm", "--out", at("out")},
              at("output"));
  // As soon as it is at work, and has its signals caught.
  for (int i = 0; i < 6000 && !std::filesystem::exists(at("out.part/slam.lcm.part")); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  map.signal(SIGINT);
  const int code = map.wait(300);
  EXPECT_EQ(code, 128 + SIGINT);
  expect_untouched({1, files::read_whole_file(at("output"))}, "interrupted; " + at("out"));
}

TEST_F(MapFolder, StaleResultsGoAndTheSavedMapThatIsReadStays) {
  ASSERT_EQ(run("marco-map", {"logs/sample.lcm", "--lines", "--out", at("out")}).code, 0);
  EXPECT_TRUE(std::filesystem::exists(at("out/lines.dxf")));
  EXPECT_FALSE(std::filesystem::exists(at("out/map.marco")));
  ASSERT_EQ(run("marco-map", {"logs/sample.lcm", "--out", at("out")}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(at("out/lines.dxf")));
  EXPECT_EQ(files::read_whole_file(at("out/note.txt")), "mine");
  const std::string map = files::read_whole_file(at("out/map.marco"));
  const Result found =
      run("marco-map", {"logs/sample.lcm", "--localize", at("out"), "--out", at("out")});
  EXPECT_EQ(found.code, 0) << found.output;
  EXPECT_TRUE(files::read_whole_file(at("out/map.marco")) == map);
}

TEST_F(MapFolder, AMapThatTheRecordingIsNotFoundInIsNotReplaced) {
  const std::string elsewhere = folder_.write("hall.log", hall()).string();
  expect_untouched(run("marco-map", {elsewhere, "--extend", at("out"), "--out", at("out")}),
                   "not found in this map");
}

}  // namespace
}  // namespace marco
