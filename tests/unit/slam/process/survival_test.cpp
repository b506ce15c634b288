// A SlamAdapter that dies and goes on, and one that takes orders.
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/batch_bus.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "slam/process/map_folder.hpp"
#include "slam/process/slam_adapter.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

class SlamSurvival : public ::testing::Test {
 protected:
  // 60 scans along a bow.
  SlamSurvival() { record({0.08, 0, 0.02}, 60); }
  // So many steps, odometry 3 % long and a little later than each scan.
  void record(const Pose2& step, int count) {
    samples_.clear();
    std::mt19937 random(5);
    SensorInfo info;
    info.parent_from_sensor = make_pose3({0.1, 0.0, 0.3});
    samples_.emplace_back(info);
    Pose2 truth{-3.0, -2.0, 0.2}, odom;
    for (int i = 0; i < count; ++i) {
      truth = truth * step;
      odom = odom * Pose2{1.03 * step.x_m, 0, step.theta_rad};
      LaserScan scan = room_.scan(truth * Pose2{0.1, 0, 0}, 0.01, &random);
      scan.utime = Utime::from_us(1'000'000 + i * 200'000);
      samples_.emplace_back(scan);
      OdometrySample odometry;
      odometry.utime = scan.utime + Duration::from_us(30'000);
      odometry.odom_from_robot = odom;
      samples_.emplace_back(odometry);
    }
  }
  static void send(process::BatchBus& bus, const Sample& sample) {
    const EncodedMessage message = encode_sample(sample);
    bus.deliver(message.channel, message.bytes, message.utime);
  }
  Trajectory run_whole() {
    process::BatchBus bus;
    SlamAdapter slam(bus, {});
    for (const Sample& sample : samples_) send(bus, sample);
    slam.finish();
    odometry_ = slam.odometry_trajectory();
    return slam.slam().trajectory();
  }
  static void set_pose(process::BatchBus& bus, const Pose2& pose) {
    slam_command_t message = {};
    message.command = slam_command_t::SET_POSE;
    message.x_m = pose.x_m;
    message.y_m = pose.y_m;
    message.theta_rad = pose.theta_rad;
    bus.deliver(channels::kSlamCommand, encode_message(message), Utime::from_us(1));
  }
  static void order(process::BatchBus& bus, int8_t command, const std::string& folder = "") {
    slam_command_t message = {};
    message.command = command;
    message.folder = folder;
    bus.deliver(channels::kSlamCommand, encode_message(message), Utime::from_us(1));
  }
  testing::FlatWorld room_ = testing::small_room();
  std::vector<Sample> samples_;
  Trajectory odometry_;  ///< of the whole run
  TemporaryFolder folder_;
};

TEST_F(SlamSurvival, KilledAtAnyMessageAndResumedItEndsWithTheSamePath) {
  const Trajectory whole = run_whole();
  const std::string path = (folder_.path() / "checkpoint").string();
  for (const std::size_t killed_after : {1U, 2U, 3U, 40U, 77U, 120U}) {
    process::BatchBus bus;
    SlamAdapter first(bus, {});
    for (std::size_t i = 0; i < killed_after; ++i) send(bus, samples_[i]);
    save_adapter_state(path, first.state());
    process::BatchBus other_bus;
    SlamAdapterOptions options;
    options.checkpoint_path = path;
    options.checkpoint_every_s = 1000.0;
    SlamAdapter resumed(other_bus, options);
    EXPECT_TRUE(resumed.resumed());
    for (std::size_t i = killed_after; i < samples_.size(); ++i) send(other_bus, samples_[i]);
    resumed.finish();
    const Trajectory poses = resumed.slam().trajectory();
    ASSERT_EQ(poses.size(), whole.size()) << killed_after;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      // All of the state is kept to the last bit.
      ASSERT_EQ(poses[i].world_from_robot.vector(), whole[i].world_from_robot.vector()) << i;
    }
    EXPECT_EQ(resumed.live_trajectory().size(), whole.size());
    ASSERT_EQ(resumed.odometry_trajectory().size(), odometry_.size());
    for (std::size_t i = 0; i < odometry_.size(); ++i) {
      EXPECT_EQ(resumed.odometry_trajectory()[i].utime, odometry_[i].utime) << i;
    }
  }
}

// 25 times round a square of 80 steps, measured with errors, tied across the rounds.
LoopWork thousands_of_keyframes() {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  LoopWork work{LoopCloser({}, CorrelativeMatcher{}, SurfelMatcher{}), {}, PoseGraph{}};
  work.robust = true;
  Pose2 believed, step;
  const Eigen::Matrix3d information = 1e4 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < 2000; ++i) {
    work.graph.add_node(believed);
    if (i > 0) work.graph.add_edge({i - 1, i, step, information, false});
    if (i >= 80 && i % 10 == 0) work.graph.add_edge({i - 80, i, Pose2{}, information, true});
    const double turn_rad = i % 20 == 19 ? std::numbers::pi / 2 : 0.0;
    step = {0.3 + 0.01 * noise(random), 0.01 * noise(random), turn_rad + 0.003 * noise(random)};
    believed = believed * step;
  }
  return work;
}

TEST_F(SlamSurvival, ScansGoOnWhileThousandsOfKeyScansAreOptimized) {
  LoopWork alone = thousands_of_keyframes();
  alone.run();
  LoopWorker worker;
  worker.start(thousands_of_keyframes());
  EXPECT_TRUE(worker.busy());
  process::BatchBus bus;
  SlamAdapter slam(bus, {});
  std::optional<LoopWork> done;
  for (const Sample& sample : samples_) {
    if (!done) done = worker.take_done();
    send(bus, sample);
  }
  EXPECT_EQ(slam.live_trajectory().size(), 60U);
  if (!done) done = worker.wait();
  ASSERT_TRUE(done.has_value());
  EXPECT_FALSE(worker.busy());
  EXPECT_FALSE(worker.wait().has_value());
  for (std::size_t i = 0; i < 2000; ++i) {
    ASSERT_EQ(done->graph.poses()[i].vector(), alone.graph.poses()[i].vector()) << i;
  }
}

TEST_F(SlamSurvival, WithLoopsInTheBackgroundItEndsAtTheSamePath) {
  const Trajectory whole = run_whole();
  process::BatchBus bus;
  SlamAdapter slam(bus, {});
  slam.close_loops_in_background();
  for (const Sample& sample : samples_) send(bus, sample);
  slam.finish();
  const Trajectory path = slam.slam().trajectory();
  ASSERT_EQ(path.size(), whole.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    // The promise is maps equal to 2 cm; here no loop is in sight.
    EXPECT_THAT(path[i].world_from_robot, IsNear(whole[i].world_from_robot, 0.02, 0.01)) << i;
  }
}

// Twice round, so that there are loops; the machine is busy in other moments.
TEST_F(SlamSurvival, LiveRunsOfOneRecordingAreEqualHoweverBusyTheMachine) {
  record({0.1, 0, 0.065}, 190);
  std::vector<Trajectory> paths;
  for (const std::size_t busy_at : {0U, 3U}) {
    process::BatchBus bus;
    SlamAdapter slam(bus, {});
    slam.close_loops_in_background();
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      send(bus, samples_[i]);
      const bool busy = i > 160 && (i / 2) % 5 == busy_at && i % 2 == 0;
      if (busy) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    if (slam.late_loop_work() > 0) {
      std::puts("SKIPPED: the machine had no time for the second thread");
      return;
    }
    slam.finish();
    EXPECT_GT(slam.slam().loops().size(), 3U);
    paths.push_back(slam.slam().trajectory());
  }
  ASSERT_EQ(paths[0].size(), paths[1].size());
  for (std::size_t i = 0; i < paths[0].size(); ++i) {
    ASSERT_EQ(paths[0][i].world_from_robot.vector(), paths[1][i].world_from_robot.vector()) << i;
  }
}

// What the second thread found long ago waits for its time: else a run would not be repeatable.
TEST_F(SlamSurvival, LoopsFoundInTheBackgroundAreTakenOverAtTheirTime) {
  record({0.1, 0, 0.065}, 190);
  SlamAdapterOptions options;
  options.loop_delay_s = 4.0;
  process::BatchBus bus;
  SlamAdapter slam(bus, options);
  slam.close_loops_in_background();
  std::vector<double> taken_s;
  std::size_t loops = 0;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    send(bus, samples_[i]);
    if (i > 160) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    const std::size_t now = slam.slam().loops().size();
    if (std::exchange(loops, now) != now) taken_s.push_back(0.1 * static_cast<double>(i));
  }
  ASSERT_GE(taken_s.size(), 2U);
  for (std::size_t i = 1; i < taken_s.size(); ++i) {
    EXPECT_GE(taken_s[i] - taken_s[i - 1], 3.9);
  }
}

TEST_F(SlamSurvival, LiveNoPathIsKeptBesideSlamsOwn) {
  process::BatchBus bus;
  SlamAdapter slam(bus, {});
  slam.close_loops_in_background();
  for (const Sample& sample : samples_) send(bus, sample);
  EXPECT_EQ(slam.live_trajectory().size(), 0U);
  EXPECT_EQ(slam.odometry_trajectory().size(), 0U);
  EXPECT_THAT(slam.state_line(), HasSubstr("60 scans"));
}

TEST_F(SlamSurvival, OfATornCheckpointTheOneBeforeIsUsed) {
  const auto path = folder_.path() / "checkpoint";
  process::BatchBus bus;
  SlamAdapter slam(bus, {});
  std::vector<std::string> warnings;
  const auto warn = [&](const std::string& line) { warnings.push_back(line); };
  EXPECT_FALSE(load_adapter_state(path, warn).has_value());
  for (std::size_t i = 0; i < 21; ++i) send(bus, samples_[i]);
  save_adapter_state(path, slam.state());
  for (std::size_t i = 21; i < 41; ++i) send(bus, samples_[i]);
  save_adapter_state(path, slam.state());
  EXPECT_EQ(load_adapter_state(path, warn)->progress.live.size(), 20U);
  const std::string bytes = files::read_whole_file(path);
  for (const std::size_t left : {bytes.size() - 1, bytes.size() / 2, std::size_t{0}}) {
    folder_.write("checkpoint", bytes.substr(0, left));
    warnings.clear();
    EXPECT_EQ(load_adapter_state(path, warn)->progress.live.size(), 10U);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_THAT(warnings.front(), HasSubstr("not used"));
  }
}

TEST_F(SlamSurvival, LiveItWritesCheckpointsByItself) {
  SlamAdapterOptions options;
  options.checkpoint_path = (folder_.path() / "checkpoint").string();
  options.checkpoint_every_s = 2.0;
  process::BatchBus bus;
  SlamAdapter slam(bus, options);
  for (std::size_t i = 0; i < 81; ++i) send(bus, samples_[i]);
  const auto state = load_adapter_state(options.checkpoint_path, {});
  ASSERT_TRUE(state.has_value());
  // 40 scans over 7.8 s: the last checkpoint is less than 2 s old.
  EXPECT_GE(state->progress.live.size(), 30U);
}

TEST_F(SlamSurvival, LiveCheckpointsAreWrittenBehindTheScans) {
  SlamAdapterOptions options;
  options.checkpoint_path = (folder_.path() / "checkpoint").string();
  options.checkpoint_every_s = 4.0;
  {
    process::BatchBus bus;
    SlamAdapter slam(bus, options);
    slam.close_loops_in_background();
    for (const Sample& sample : samples_) send(bus, sample);
    EXPECT_EQ(slam.drops().by_cause().count("checkpoint: cannot be written"), 0U);
  }
  const auto state = load_adapter_state(options.checkpoint_path, {});
  ASSERT_TRUE(state.has_value());
  EXPECT_GE(state->progress.scan_count, 20);
  EXPECT_TRUE(state->progress.live.empty());
}

TEST_F(SlamSurvival, ItSavesLocalizesPausesAndForgetsByOrder) {
  SlamAdapterOptions options;
  options.maps_folder = folder_.path().string();
  process::BatchBus bus;
  SlamAdapter slam(bus, options);
  for (std::size_t i = 0; i < 61; ++i) send(bus, samples_[i]);
  order(bus, slam_command_t::SAVE, "hall");
  EXPECT_THAT(slam.take_reply(), HasSubstr("saved"));
  EXPECT_EQ(slam.take_reply(), "");
  for (const char* name : {"map.marco", "map_1.pgm", "map.yaml", "trajectory.tum"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "hall" / name)) << name;
  }
  EXPECT_EQ(load_map_folder(folder_.path() / "hall").slam.path.scans.size(), 30U);

  order(bus, slam_command_t::PAUSE);
  for (std::size_t i = 61; i < 63; ++i) send(bus, samples_[i]);
  EXPECT_EQ(slam.live_trajectory().size(), 30U);
  EXPECT_EQ(slam.drops().by_cause().at("paused"), 1);
  order(bus, slam_command_t::RESUME);
  EXPECT_THAT(slam.take_reply(), HasSubstr("PAUSE"));
  EXPECT_THAT(slam.take_reply(), HasSubstr("RESUME"));

  order(bus, slam_command_t::LOCALIZE, "hall");
  EXPECT_THAT(slam.take_reply(), HasSubstr("relocalizing"));
  EXPECT_THAT(slam.state_line(), HasSubstr("not found in the map yet"));
  for (std::size_t i = 1; i < samples_.size(); ++i) send(bus, samples_[i]);
  EXPECT_THAT(slam.state_line(), HasSubstr("localized"));
  order(bus, slam_command_t::SAVE, "hall");
  EXPECT_THAT(slam.take_reply(), HasSubstr("refused"));

  order(bus, slam_command_t::RESET);
  EXPECT_EQ(slam.slam().key_count(), 0U);
  EXPECT_EQ(slam.session().mode(), MappingSession::Mode::mapping);
}

TEST_F(SlamSurvival, WhatIsRefusedLeavesTheMapAsItIs) {
  SlamAdapterOptions options;
  options.maps_folder = folder_.path().string();
  std::filesystem::create_directory(folder_.path() / "hall");
  folder_.write("hall/map.marco", "something else");
  const double nan = std::nan("");
  process::BatchBus bus;
  SlamAdapter slam(bus, options);
  for (std::size_t i = 0; i < samples_.size() / 2; ++i) send(bus, samples_[i]);
  const std::string before = encode_adapter_state(slam.state());
  for (const Pose2& pose :
       {Pose2{1e9, 0, 0}, Pose2{0, -1e300, 0}, Pose2{nan, 0, 0}, Pose2{0, 0, nan}}) {
    set_pose(bus, pose);
    EXPECT_THAT(slam.take_reply(), HasSubstr("refused: SET_POSE: the pose must be finite"));
  }
  for (const char* folder : {"hall", "nowhere", "../hall", ""}) {
    order(bus, slam_command_t::LOCALIZE, folder);
    EXPECT_NE(slam.take_reply(), "");
  }
  folder_.write("file", "");
  order(bus, slam_command_t::SAVE, "file");
  EXPECT_THAT(slam.take_reply(), HasSubstr("failed: "));
  order(bus, 77);
  // Only that they were refused is known of them.
  AdapterState state = slam.state();
  EXPECT_EQ(state.drops.at("slam_command_t: refused") + state.drops.at("slam_command_t: failed"),
            10);
  state.drops = decode_adapter_state(before).drops;
  state.received = decode_adapter_state(before).received;
  EXPECT_EQ(encode_adapter_state(state), before);
  for (std::size_t i = samples_.size() / 2; i < samples_.size(); ++i) send(bus, samples_[i]);
  slam.finish();
  const Trajectory path = slam.slam().trajectory(), whole = run_whole();
  ASSERT_EQ(path.size(), whole.size());
  EXPECT_EQ(path.back().world_from_robot.vector(), whole.back().world_from_robot.vector());
}

TEST_F(SlamSurvival, OrdersThatLeadOutOfTheMapsFolderOrNowhereAreRefused) {
  SlamAdapterOptions options;
  options.maps_folder = folder_.path().string();
  process::BatchBus bus;
  SlamAdapter slam(bus, options);
  for (const char* folder : {"/etc", "../elsewhere", "a/../../b", ""}) {
    order(bus, slam_command_t::SAVE, folder);
    EXPECT_THAT(slam.take_reply(), HasSubstr("refused")) << folder;
  }
  order(bus, slam_command_t::LOCALIZE, "no such map");
  EXPECT_THAT(slam.take_reply(), HasSubstr("cannot be read"));
  order(bus, 77);
  EXPECT_THAT(slam.take_reply(), HasSubstr("not a command"));
  folder_.write("map.marco", "something else");
  EXPECT_THAT(complaint([&] { load_map_folder(folder_.path()); }),
              HasSubstr("map.marco: is no MARCOMAP file"));
}

}  // namespace
}  // namespace marco::slam
