// Real recordings through the main job, with budgets. They are not ours to ship: MARCO_TEST_DATA
// says where they lie.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <sstream>

#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/real_data.hpp"

namespace marco {
namespace {

using ::marco::testing::Program;
using ::marco::testing::TemporaryFolder;

class RealLogs : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = marco::testing::real_data();
    if (folder == nullptr) GTEST_SKIP();
    data_ = folder;
  }
  // @param code  what it may end with, beside 0
  std::string run(const std::string& name,
                  const std::vector<std::string>& arguments,
                  int code = 0) {
    const std::string output = (folder_.path() / "output").string();
    Program program(name, arguments, output);
    EXPECT_THAT(program.wait(200), ::testing::AnyOf(0, code)) << files::read_whole_file(output);
    return files::read_whole_file(output);
  }
  // @returns report.json
  nlohmann::json map(const std::string& input) { return map_file(data_ + "/" + input); }
  nlohmann::json map_file(const std::string& path) {
    run("marco-map", {path, "--out", out()});
    return nlohmann::json::parse(files::read_whole_file(out() + "/report.json"));
  }
  std::string out() const { return (folder_.path() / "out").string(); }
  // The number behind `key` in a line of key=value pairs.
  static double number(const std::string& text, const std::string& key) {
    std::smatch found;
    if (!std::regex_search(text, found, std::regex(key + "=([0-9.]+)"))) return -1.0;
    return std::stod(found[1]);
  }

  TemporaryFolder folder_;
  std::string data_;
};

TEST_F(RealLogs, IntelIsMappedToTheReferencesOwnNoise) {
  map("intel/intel.log");
  EXPECT_EQ(files::read_tum(out() + "/trajectory.tum").size(), 5505U);
  const std::string relations = data_ + "/intel/intel.relations";
  const std::string error = run("marco-evaluate", {out() + "/trajectory.tum", relations});
  EXPECT_EQ(number(error, "n"), 1030);
  EXPECT_LT(number(error, "translation_m mean"), 0.0195);
  EXPECT_LT(number(error, "rotation_deg mean"), 0.29);
  const std::string odometry = run("marco-evaluate", {out() + "/odometry.tum", relations});
  EXPECT_NEAR(number(odometry, "translation_m mean"), 3.53, 0.01);
  // The reference metric prints the same line.
  const std::string metric = data_ + "/../tools/relations_metric.py";
  if (!std::filesystem::exists(metric)) return;
  const std::string reference = run("python3", {metric, out() + "/trajectory.tum", relations});
  for (const char* key : {"translation_m mean", "std", "p95", "max", "rotation_deg mean"}) {
    EXPECT_EQ(number(error, key), number(reference, key)) << key;
  }
}

// Its stamps jitter by more than the laser's period; four of five scans are left out.
TEST_F(RealLogs, IntelIsMappedByAFifthOfItsScans) {
  std::mt19937 random(1);
  std::istringstream all(files::read_whole_file(data_ + "/intel/intel.log"));
  std::ofstream thinned(folder_.path() / "thinned.log");
  for (std::string line; std::getline(all, line);) {
    if (!line.starts_with("FLASER") || random() % 5 == 0) thinned << line << '\n';
  }
  thinned.close();
  run("marco-map", {(folder_.path() / "thinned.log").string(), "--out", out()});
  const std::string error =
      run("marco-evaluate", {out() + "/trajectory.tum", data_ + "/intel/intel.relations"});
  EXPECT_GT(number(error, "n"), 20);
  EXPECT_LT(number(error, "translation_m mean"), 0.04);
}

TEST_F(RealLogs, IntelsWallsAreMappedToTenCentimetres) {
  // One place is half a metre off: the doctor may say so.
  constexpr int kVerdictWrong = 3;
  run("marco-map", {data_ + "/intel/intel.log", "--lines", "--out", out()}, kVerdictWrong);
  const std::string error =
      run("marco-evaluate", {out() + "/trajectory.tum", data_ + "/intel/intel.relations"});
  EXPECT_EQ(number(error, "n"), 1030);
  EXPECT_LT(number(error, "translation_m mean"), 0.10);
}

TEST_F(RealLogs, MbotIsMappedWithoutOdometryToTwoOfItsLasersCentimetres) {
  const nlohmann::json report = map("mbot/mbot_convex.lcmlog");
  EXPECT_LT(report.at("errors").at("path error rms_m"), 0.02);
}

// Its driver counts bearings and times the other way round, on a channel that could be ours.
TEST_F(RealLogs, MbotWithItsDriverOf2023IsMappedAsWell) {
  const std::string log = (folder_.path() / "2023.lcmlog").string();
  run("python3", {"tests/experiments/mbot_2023.py", data_ + "/mbot/mbot_convex.lcmlog", log});
  const nlohmann::json report = map_file(log);
  EXPECT_LT(report.at("errors").at("path error rms_m"), 0.02);
  // It was read right, not mended afterwards.
  EXPECT_TRUE(report.at("scans").at("dropped").empty());
  EXPECT_EQ(report.at("verdict"), "good");
}

TEST_F(RealLogs, TheOthersAreMappedWithMostScansMatched) {
  for (const auto& [input, scans] : std::map<std::string, int>{{"mbot/maebot_convex.lcmlog", 459},
                                                               {"fr101/fr101.log", 292},
                                                               {"loop5/loop5.log", 551}}) {
    const nlohmann::json report = map(input);
    EXPECT_EQ(report.at("scans").at("posed"), scans) << input;
    EXPECT_GT(report.at("scans").at("matched"), 0.97 * scans) << input;
  }
}

TEST_F(RealLogs, ThreeNoddingScansBecomeOneCorridor) {
  map("nodding_lms");
  const TriangleMesh model = files::read_ply(out() + "/model.ply");
  EXPECT_GT(model.triangles.size(), 200000U);
  const Trajectory path = files::read_tum(out() + "/trajectory.tum");
  // Its start guesses say 1.57 m and 3.38 m, good to some centimetres.
  EXPECT_NEAR(path.back().world_from_robot.x_m, 3.38, 0.1);
  EXPECT_NEAR(path.back().world_from_robot.y_m, 0.0, 0.15);
}

}  // namespace
}  // namespace marco
