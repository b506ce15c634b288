// A SlamAdapter that dies and goes on.
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "lcm_tools/files/whole_file.hpp"
#include "slam/process/map_folder.hpp"
#include "tests/support/matchers.hpp"
#include "tests/unit/slam/process/slam_adapter_fixture.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::testing::HasSubstr;

using SlamSurvival = SlamAdapterFixture;

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

}  // namespace
}  // namespace marco::slam
