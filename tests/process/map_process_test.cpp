// marco-map as a user starts it: bad input, the same twice, and live what it is in batch.
#include <gmock/gmock.h>
#include <sys/mount.h>

#include <nlohmann/json.hpp>

#include "common/files/event_log.hpp"
#include "common/files/tum.hpp"
#include "common/files/whole_file.hpp"
#include "common/process/lcm_bus.hpp"
#include "common/trajectory_fit.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/process_status_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"

namespace marco {
namespace {

using ::marco::testing::Program;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

constexpr const char* kShortTour = R"(
start_m = [2.0, 3.0]
[[steps]]
kind = "sweep"
pans_deg = [0, 90]
rows = 40
[[steps]]
to_m = [5.6, 2.2]
[[steps]]
to_m = [9.6, 2.6]
[[steps]]
kind = "face"
heading_deg = 150
[[steps]]
to_m = [7.0, 4.0]
)";

class MapProcess : public ::testing::Test {
 protected:
  struct Result {
    int code = 0;
    std::string output;
  };
  Result run(const std::string& name,
             const std::vector<std::string>& arguments,
             double seconds = 100) {
    const std::string output = (folder_.path() / "output").string();
    Program program(name, arguments, output);
    const int code = program.wait(seconds);
    return {code, files::read_whole_file(output)};
  }
  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string simulate() {
    const auto tour = folder_.write("tour.toml", kShortTour);
    const Result result = run("marco-simulate", {"--world", "config/worlds/lab.toml", "--tour",
                                                 tour.string(), "--out", at("short.lcm")});
    EXPECT_EQ(result.code, 0) << result.output;
    return at("short.lcm");
  }
  nlohmann::json report(const std::string& out) const {
    return nlohmann::json::parse(files::read_whole_file(out + "/report.json"));
  }

  TemporaryFolder folder_;
};

TEST_F(MapProcess, MakesEverythingAndMeasuresItAgainstTheTruth) {
  const Result result =
      run("marco-map", {simulate(), "--out", at("out"), "--world", "config/worlds/lab.toml"});
  ASSERT_EQ(result.code, 0) << result.output;
  for (const char* name :
       {"map.pgm", "map.yaml", "map.png", "trajectory.tum", "trajectory_live.tum", "odometry.tum",
        "truth.tum", "model.ply", "model_scenes.ply", "model.glb", "model.obj", "planes.json",
        "floor_plan.svg", "model.png", "slam.lcm", "report.json"}) {
    EXPECT_TRUE(std::filesystem::exists(at("out") + "/" + name)) << name;
  }
  const nlohmann::json errors = report(at("out")).at("errors");
  // The range noise is 10 mm; a path off by more is no measurement of 361 beams.
  EXPECT_LT(errors.at("path error rms_m"), 0.01);
  EXPECT_GT(errors.at("odometry error rms_m"), 0.05);
  // Cells of 50 mm: their centres lie up to 35 mm from the wall that runs through them.
  EXPECT_LT(errors.at("map error rms_m"), 0.035);
  // Two of twelve sweeps, their scenes not yet registered in 3D: the floor's unevenness is in it.
  EXPECT_LT(errors.at("model error rms_m"), 0.02);
  const nlohmann::json surface = report(at("out")).at("surface");
  EXPECT_LT(surface.at("simplified triangles"), 0.1 * surface.at("triangles").get<double>());
  EXPECT_LE(surface.at("simplified, part beyond the bound"), 0.001);
  const auto scans = files::read_tum(at("out") + "/truth.tum").size();
  EXPECT_EQ(files::read_tum(at("out") + "/trajectory.tum").size(), scans);
  EXPECT_EQ(files::read_tum(at("out") + "/trajectory_live.tum").size(), scans);
}

TEST_F(MapProcess, TwoRunsAreTheSameToTheLastByte) {
  const std::string log = simulate();
  ASSERT_EQ(run("marco-map", {log, "--out", at("one")}).code, 0);
  ASSERT_EQ(run("marco-map", {log, "--out", at("two")}).code, 0);
  for (const char* name :
       {"slam.lcm", "trajectory.tum", "trajectory_live.tum", "map.pgm", "model.ply", "model.glb",
        "model.obj", "planes.json", "floor_plan.svg"}) {
    EXPECT_TRUE(files::read_whole_file(at("one") + "/" + name) ==
                files::read_whole_file(at("two") + "/" + name))
        << name;
  }
}

TEST_F(MapProcess, WhatCannotBeReadIsSaidAndTheExitCodeIsNotZero) {
  const auto fails = [&](const std::string& input) {
    const Result result = run("marco-map", {input, "--out", at("out")});
    EXPECT_EQ(result.code, 1) << result.output;
    return result.output;
  };
  EXPECT_THAT(fails("/nonexistent/log"), HasSubstr("/nonexistent/log: there is no such file"));
  EXPECT_THAT(fails(folder_.write("empty", "").string()), HasSubstr("empty"));
  EXPECT_THAT(fails(folder_.path().string()), HasSubstr("no 3D scan"));
  EXPECT_THAT(fails(folder_.write("p.log", "\x89PNG\r\n\x1a\n1234").string()),
              HasSubstr("PNG picture"));
}

TEST_F(MapProcess, ADamagedLogIsUsedAsFarAsItIsGood) {
  const std::string log = simulate();
  ASSERT_EQ(run("marco-map", {log, "--out", at("whole")}).code, 0);
  std::string bytes = files::read_whole_file(log);
  bytes.resize(bytes.size() - 100);  // ends within an event
  for (int i = 0; i < 100; ++i) {
    char& byte = bytes[static_cast<std::size_t>(i + 1) * (bytes.size() / 102)];
    byte = static_cast<char>(byte ^ (1 << (i % 8)));
  }
  const Result result =
      run("marco-map", {folder_.write("damaged", bytes).string(), "--out", at("out")});
  ASSERT_EQ(result.code, 0) << result.output;
  const nlohmann::json found = report(at("out"));
  EXPECT_GE(found.at("inputs").at(0).at("dropped").size(), 2U);
  // 100 events of thousands were hit: most scans must still be matched or passed by as tilted.
  EXPECT_GT(found.at("scans").at("posed"), 700);
  // The damaged log's own truth is damaged too.
  const TrajectoryFit fit = fit_to_truth(files::read_tum(at("out/trajectory.tum")),
                                         files::read_tum(at("whole/truth.tum")));
  EXPECT_LT(fit.rms_m, 0.02);
}

TEST_F(MapProcess, AFullDiskIsAFailureThatNamesTheFile) {
  const auto full = folder_.path() / "full";
  std::filesystem::create_directory(full);
  if (mount("none", full.c_str(), "tmpfs", 0, "size=1m") != 0) {
    std::printf("SKIPPED: no tmpfs of our own here\n");
    return;
  }
  const std::string log = simulate();
  const Result result = run("marco-map", {log, "--out", full.string()});
  umount(full.c_str());
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.output, HasSubstr("slam.lcm"));
  EXPECT_THAT(result.output, HasSubstr("No space left"));
}

// Poses by stamp, from SLAM_POSE.
using Poses = std::map<int64_t, Pose2>;

TEST_F(MapProcess, ALogReplayedIntoTheLiveProcessGivesThePosesOfTheBatchRun) {
  const std::string log = simulate();
  ASSERT_EQ(run("marco-map", {log, "--out", at("batch")}).code, 0);
  process::LcmBus bus("");
  process::DropCounter drops;
  Poses live;
  bool slam_is_up = false;
  bus.subscribe<process_status_t>(channels::kProcessStatus, drops,
                                  [&](const auto&, const auto&) { slam_is_up = true; });
  bus.subscribe<slam_pose_t>(channels::kSlamPose, drops, [&](const auto& pose, const auto&) {
    live[pose.utime] = {pose.x_m, pose.y_m, pose.theta_rad};
  });
  Program slam("marco-slam", {}, at("slam.out"));
  for (int i = 0; i < 100 && !slam_is_up; ++i) bus.handle_once(100);
  ASSERT_TRUE(slam_is_up) << files::read_whole_file(at("slam.out"));
  Program player("lcm-logplayer", {"--speed=2", log}, at("player.out"));
  const Trajectory batch = files::read_tum(at("batch/trajectory_live.tum"));
  // Ends when all have come, or nothing has come for two seconds.
  for (int silent = 0; silent < 20 && live.size() < batch.size();)
    silent = bus.handle_once(100) ? 0 : silent + 1;
  slam.signal(SIGTERM);
  EXPECT_EQ(slam.wait(20), 0);
  std::size_t met = 0;
  for (const StampedPose2& pose : batch) {
    const auto same = live.find(pose.utime.us);
    if (same == live.end()) continue;
    ++met;
    const Pose2 off = between(pose.world_from_robot, same->second);
    ASSERT_LT(off.translation_m().norm(), 0.001) << "at " << pose.utime.us;
    ASSERT_LT(std::abs(off.theta_rad), 0.001) << "at " << pose.utime.us;
  }
  // The last scan waits for odometry that never comes.
  EXPECT_GE(met + 3, batch.size());
}

}  // namespace
}  // namespace marco
