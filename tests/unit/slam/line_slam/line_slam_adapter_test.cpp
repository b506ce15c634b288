#include "slam/process/line_slam_adapter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "lcm_tools/process/batch_bus.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/line_map_t.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_command_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "tests/support/lines_drive.hpp"
#include "tests/support/lines_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using process::BatchBus;
using process::DropCounter;
using process::RawMessage;
using testing::IsNear;
using testing::TemporaryFolder;

// A robot on a short drive, its messages and what it publishes.
class Drive {
 public:
  explicit Drive(unsigned seed = 3) : random_(seed) {
    tour_ = testing::drive({{1.5, 1.5}, {4.5, 1.5}, {6.0, 2.2}}, 0.1, 0.1, {}, random_);
    for (std::size_t i = 0; i < tour_.world_from_robot.size(); ++i) {
      const auto taken = testing::take_scan(world_, laser_, tour_.world_from_robot[i], random_);
      LaserScan scan;
      scan.utime = stamp(i);
      for (const Beam& beam : taken.scan.beams) {
        scan.ranges_m.push_back(beam.returned ? static_cast<float>(beam.range_m) : 0.0F);
      }
      scan.first_bearing_rad = laser_.first_rad;
      scan.bearing_step_rad = laser_.step_rad;
      scans_.push_back(scan);
      odometry_.push_back(i == 0 ? Pose2{} : odometry_.back() * tour_.odometry_steps[i - 1]);
    }
  }
  static Utime stamp(std::size_t i) {
    return Utime::from_us(1000000 + 100000 * static_cast<int64_t>(i));
  }
  std::size_t size() const { return scans_.size(); }
  Pose2 truth_from_start(std::size_t i) const {
    return between(tour_.world_from_robot[0], tour_.world_from_robot[i]);
  }

  void send_info(BatchBus& bus) const {
    SensorInfo info;
    info.range_max_m = 30.0;
    info.range_sigma_m = 0.01;
    bus.deliver(channels::kSensorInfo, encode_message(to_message(info)), {});
  }
  void send_scan(BatchBus& bus, std::size_t i) const {
    bus.deliver(channels::kLidar, encode_message(to_message(scans_[i])), {});
  }
  void send_odometry(BatchBus& bus, std::size_t i, const Pose2& begun = {}) const {
    OdometrySample sample;
    sample.utime = stamp(i);
    sample.odom_from_robot = begun * odometry_[i];
    bus.deliver(channels::kOdometry, encode_message(to_message(sample)), {});
  }

 private:
  std::mt19937 random_;
  testing::LinesWorld world_ = testing::make_loop_world();
  testing::LinesLaser laser_;
  testing::LinesDrive tour_;
  std::vector<LaserScan> scans_;
  std::vector<Pose2> odometry_;
};

struct Published {
  explicit Published(BatchBus& bus) {
    bus.subscribe<slam_pose_t>(
        channels::kSlamPose, drops,
        [this](const slam_pose_t& pose, const RawMessage&) { poses.push_back(pose); });
    bus.subscribe<line_map_t>(
        channels::kLineMap, drops,
        [this](const line_map_t& map, const RawMessage&) { maps.push_back(map); });
  }
  Pose2 last() const { return {poses.back().x_m, poses.back().y_m, poses.back().theta_rad}; }
  DropCounter drops;
  std::vector<slam_pose_t> poses;
  std::vector<line_map_t> maps;
};

std::string temporary(const std::string& name) {
  const std::string path = ::testing::TempDir() + name;
  std::filesystem::remove(path);
  return path;
}

// One adapter with the defaults.
class LineSlamAdapterTest : public ::testing::Test {
 protected:
  void finish() {
    adapter.finish();
    bus.deliver("ANY", {}, {});  // hands on what finish() published
  }
  const Drive drive;
  BatchBus bus;
  Published published{bus};
  LineSlamAdapter adapter{{}, bus};
};

TEST_F(LineSlamAdapterTest, PublishesAPoseAScanAndAMap) {
  drive.send_info(bus);
  for (std::size_t i = 0; i < drive.size(); ++i) {
    drive.send_scan(bus, i);  // odometry comes after: the scan must wait for it
    drive.send_odometry(bus, i);
  }
  ASSERT_EQ(published.poses.size(), drive.size());
  // A centimetre and a third of a degree: walls at 1 cm noise, three metres driven.
  EXPECT_THAT(published.last(), IsNear(drive.truth_from_start(drive.size() - 1), 0.01, 0.005));
  EXPECT_EQ(published.poses.back().status, int8_t{slam_pose_t::STATUS_MATCHED});
  EXPECT_GT(published.poses.back().covariance[0][0], 0.0);
  ASSERT_FALSE(published.maps.empty());
  EXPECT_EQ(adapter.drops().dropped(), 0);
  bus.deliver(channels::kMapRequest, encode_message(map_request_t{}), {});
  EXPECT_GE(from_message(published.maps.back()).size(), 5U);
}

TEST_F(LineSlamAdapterTest, DropsScansUntilTheSensorIsKnown) {
  drive.send_odometry(bus, 0);
  drive.send_scan(bus, 0);
  EXPECT_TRUE(published.poses.empty());
  EXPECT_EQ(adapter.drops().by_cause().at("no SENSOR_INFO for LIDAR yet"), 1);
}

TEST_F(LineSlamAdapterTest, FollowsWithoutAnyOdometry) {
  drive.send_info(bus);
  for (std::size_t i = 0; i < drive.size(); ++i) drive.send_scan(bus, i);
  finish();
  ASSERT_EQ(published.poses.size(), drive.size());
  EXPECT_THAT(published.last(), IsNear(drive.truth_from_start(drive.size() - 1), 0.03, 0.01));
}

// A base that was killed counts from zero when it is back.
TEST_F(LineSlamAdapterTest, OdometryThatBeginsAnewMovesNothing) {
  drive.send_info(bus);
  for (std::size_t i = 0; i < drive.size(); ++i) {
    drive.send_scan(bus, i);
    // Silent for two scans between.
    if (i == 14 || i == 15) continue;
    drive.send_odometry(bus, i, i < 14 ? Pose2{5.0, 2.0, 0.4} : Pose2{});
  }
  finish();
  ASSERT_EQ(published.poses.size(), drive.size());
  EXPECT_EQ(adapter.drops().by_cause().at("odometry restarted: ignored for one scan"), 1);
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Pose2 pose{published.poses[i].x_m, published.poses[i].y_m, published.poses[i].theta_rad};
    // As without any odometry.
    EXPECT_THAT(pose, IsNear(drive.truth_from_start(i), 0.03, 0.01)) << i;
  }
}

TEST_F(LineSlamAdapterTest, PassesTiltedScansByAndCarriesThePoseOn) {
  SensorInfo base;
  base.channel = channels::kPanTiltState;
  SensorInfo laser;
  laser.mount = SensorInfo::Mount::pantilt;
  laser.range_max_m = 30.0;
  bus.deliver(channels::kSensorInfo, encode_message(to_message(base)), {});
  bus.deliver(channels::kSensorInfo, encode_message(to_message(laser)), {});
  const auto tilt = [&](std::size_t i, double tilt_rad) {
    PanTiltState state;
    state.utime = Drive::stamp(i);
    state.tilt_rad = tilt_rad;
    bus.deliver(channels::kPanTiltState, encode_message(to_message(state)), {});
  };
  for (std::size_t i = 0; i < 20; ++i) {
    tilt(i, i >= 10 && i < 15 ? 0.2 : 0.001);
    drive.send_odometry(bus, i);
    drive.send_scan(bus, i);
  }
  EXPECT_EQ(adapter.drops().by_cause().at("tilted"), 5);
  EXPECT_EQ(adapter.scans_used(), 15);
  ASSERT_EQ(published.poses.size(), 20U);
  EXPECT_EQ(published.poses[12].status, int8_t{slam_pose_t::STATUS_PREDICTED});
  EXPECT_GT(published.poses[14].covariance[0][0], published.poses[9].covariance[0][0]);
  EXPECT_EQ(published.poses[19].status, int8_t{slam_pose_t::STATUS_MATCHED});
  EXPECT_THAT(published.last(), IsNear(drive.truth_from_start(19), 0.02, 0.01));
}

// The filter is replayed along all keyframes: none may be culled.
TEST(LineProcessOptions, HaveNoSettingThatIsNotHeeded) {
  LineProcessOptions options;
  EXPECT_EQ(process::print_options(options).find("culling"), std::string::npos);
  EXPECT_THROW(process::parse_options("[slam.culling]\nafter_keyframes = 10\n", options, "a file"),
               std::invalid_argument);
  process::parse_options("[slam]\nkeyframe_distance_m = 0.5\n", options, "a file");
  EXPECT_EQ(options.mapper.slam.keyframes.keyframe_distance_m, 0.5);
}

TEST(LineSlamAdapter, GoesOnFromItsCheckpointAsIfNothingHadHappened) {
  const Drive drive;
  LineProcessOptions options;
  options.checkpoint_path = temporary("line_slam.checkpoint");
  options.checkpoint_every_s = 0.01;  // after each scan
  const std::size_t half = drive.size() / 2;
  const auto feed = [&](BatchBus& bus, std::size_t from, std::size_t to) {
    drive.send_info(bus);
    for (std::size_t i = from; i < to; ++i) {
      drive.send_odometry(bus, i);
      drive.send_scan(bus, i);
    }
  };
  BatchBus whole_bus;
  Published whole(whole_bus);
  LineSlamAdapter never_stopped({}, whole_bus);
  feed(whole_bus, 0, drive.size());
  {
    BatchBus bus;
    LineSlamAdapter first(options, bus);
    EXPECT_FALSE(first.resumed());
    feed(bus, 0, half);  // and it is killed
  }
  BatchBus bus;
  Published published(bus);
  LineSlamAdapter second(options, bus);
  EXPECT_TRUE(second.resumed());
  feed(bus, half, drive.size());
  // The same numbers in another order of storage: rounding only.
  EXPECT_THAT(published.last(), IsNear(whole.last(), 1e-9, 1e-9));
}

TEST(LineSlamAdapter, TwoRunsWriteTheSameJournal) {
  const Drive drive;
  std::string texts[2];
  for (std::string& text : texts) {
    LineProcessOptions options;
    options.journal_path = temporary("line_slam.jsonl");
    BatchBus bus;
    LineSlamAdapter adapter(options, bus);
    drive.send_info(bus);
    for (std::size_t i = 0; i < 5; ++i) {
      drive.send_odometry(bus, i);
      drive.send_scan(bus, i);
    }
    adapter.finish();
    std::ifstream file(options.journal_path);
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  EXPECT_EQ(std::count(texts[0].begin(), texts[0].end(), '\n'), 5);
  EXPECT_THAT(texts[0], ::testing::HasSubstr("\"S\":"));
  EXPECT_EQ(texts[0], texts[1]);
}

TEST_F(LineSlamAdapterTest, ResetStartsAgain) {
  drive.send_info(bus);
  drive.send_odometry(bus, 0);
  drive.send_scan(bus, 0);
  slam_command_t command{};
  command.command = slam_command_t::SET_POSE;
  command.x_m = 5.0;
  bus.deliver(channels::kSlamCommand, encode_message(command), {});
  EXPECT_EQ(adapter.mapper().filter().num_walls(), 0U);
  EXPECT_THAT(adapter.mapper().world_from_robot(), IsNear(Pose2{5.0, 0.0, 0.0}, 1e-12, 1e-12));
  command.command = slam_command_t::PAUSE;
  bus.deliver(channels::kSlamCommand, encode_message(command), {});
  drive.send_scan(bus, 1);
  EXPECT_EQ(adapter.drops().by_cause().at("paused"), 1);
}

TEST_F(LineSlamAdapterTest, WhatIsRefusedLeavesTheMapAsItIs) {
  drive.send_info(bus);
  for (std::size_t i = 0; i < 5; ++i) {
    drive.send_odometry(bus, i);
    drive.send_scan(bus, i);
  }
  const auto before = adapter.mapper().world_from_robot();
  const auto walls = adapter.mapper().filter().num_walls();
  ASSERT_GT(walls, 0U);
  slam_command_t command{};
  command.command = slam_command_t::SET_POSE;
  for (const double far : {1e300, -1e9, std::nan("")}) {
    command.x_m = far;
    bus.deliver(channels::kSlamCommand, encode_message(command), {});
    EXPECT_THAT(adapter.take_reply().value().text, ::testing::HasSubstr("refused: SET_POSE"));
  }
  command.command = slam_command_t::LOCALIZE;
  command.folder = "hall";
  bus.deliver(channels::kSlamCommand, encode_message(command), {});
  EXPECT_THAT(adapter.take_reply().value().text, ::testing::HasSubstr("refused: LOCALIZE"));
  EXPECT_EQ(adapter.mapper().filter().num_walls(), walls);
  EXPECT_EQ(adapter.mapper().world_from_robot().vector(), before.vector());
}

TEST(LineSlamAdapter, SavesOnlyWithinItsFolderAndNeverDiesOfIt) {
  const TemporaryFolder folder;
  LineProcessOptions options;
  options.maps_folder = folder.path() / "maps";
  std::filesystem::create_directories(options.maps_folder + "/mine");
  BatchBus bus;
  LineSlamAdapter adapter(options, bus);
  slam_command_t command{};
  command.command = slam_command_t::SAVE;
  for (const std::string& name : {std::string("../evil"), folder.path().string(),
                                  std::string("mine/../../evil"), std::string("not/there")}) {
    command.folder = name;
    const int64_t before = adapter.drops().dropped();
    bus.deliver(channels::kSlamCommand, encode_message(command), {});
    EXPECT_EQ(adapter.drops().dropped(), before + 1) << name;
  }
  EXPECT_TRUE(std::filesystem::is_empty(options.maps_folder + "/mine"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "line_slam.checkpoint"));
  command.folder = "mine";
  bus.deliver(channels::kSlamCommand, encode_message(command), {});
  EXPECT_TRUE(std::filesystem::exists(options.maps_folder + "/mine/line_slam.checkpoint"));

  LineProcessOptions none;
  none.maps_folder = "";
  LineSlamAdapter nowhere(none, bus);
  bus.deliver(channels::kSlamCommand, encode_message(command), {});
  EXPECT_EQ(nowhere.take_reply().value().text, "refused: SAVE: no folder for maps is configured");
}

}  // namespace
}  // namespace marco::slam
