// marco-slam live: orders over LCM, answered in PROCESS_STATUS; killed, it goes on.
#include <gmock/gmock.h>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/process_status_t.hpp"
#include "marco/slam_command_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "marco/slam_reply_t.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;
using ::marco::testing::Program;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

class SlamOrders : public ::testing::Test {
 protected:
  SlamOrders() : bus_("") {
    bus_.subscribe<process_status_t>(
        channels::kProcessStatus, heard_,
        [this](const auto& status, const auto&) { states_.push_back(status.state); });
    bus_.subscribe<slam_pose_t>(channels::kSlamPose, heard_, [this](const auto& pose, const auto&) {
      last_ = pose;
      ++poses_;
    });
    bus_.subscribe<slam_reply_t>(
        channels::kSlamReply, heard_,
        [this](const auto& reply, const auto&) { replies_.push_back(reply); });
    folder_.write("slam.toml", "maps_folder = \"" + folder_.path().string() +
                                   "\"\ncheckpoint_path = \"" + at("checkpoint") +
                                   "\"\ncheckpoint_every_s = 1.0\n");
  }
  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }
  std::unique_ptr<Program> start(const std::string& name = "marco-slam") {
    states_.clear();
    auto slam = std::make_unique<Program>(
        name, std::vector<std::string>{"--config", at("slam.toml")}, at("slam.out"));
    EXPECT_TRUE(hears("")) << files::read_whole_file(at("slam.out"));
    return slam;
  }
  // Whether a process says, within 10 s, a state that holds `text`.
  bool hears(const std::string& text) {
    for (int i = 0; i < 100; ++i) {
      for (const std::string& state : states_) {
        if (state.find(text) != std::string::npos) return true;
      }
      bus_.handle_once(100);
    }
    return false;
  }
  void send(const Sample& sample) {
    const EncodedMessage message = encode_sample(sample);
    bus_.publish_raw(message.channel, message.bytes, message.utime);
  }
  void order(int8_t command, const std::string& folder, int64_t age_us = 0) {
    states_.clear();
    slam_command_t message = {};
    message.utime = process::wall_clock_us() - age_us;
    ordered_us_.push_back(message.utime);
    message.command = command;
    message.folder = folder;
    bus_.publish(channels::kSlamCommand, message);
  }
  // Scans `first` to `last` of a drive through the room; each waits for the pose of the one before.
  void drive(int first, int last) {
    SensorInfo info;
    send(info);
    for (int i = first; i < last; ++i) {
      LaserScan scan = room_.scan(true_pose(i));
      scan.utime = Utime::from_us(1'000'000 + off_us_ + i * 100'000);
      OdometrySample odometry;
      odometry.utime = scan.utime;
      odometry.odom_from_robot = odom_from_world_ * true_pose(i);
      send(odometry);
      const int before = poses_;
      send(scan);
      for (int wait = 0; wait < 50 && poses_ == before; ++wait) bus_.handle_once(100);
    }
  }
  Pose2 true_pose(int i) const {
    Pose2 pose = start_;
    for (int step = 0; step < i; ++step) pose = pose * step_;
    return pose;
  }
  // As after a power cut: later, and odometry begins anew.
  void switch_off_and_on(const Pose2& at) {
    off_us_ += 1'000'000'000;
    start_ = at;
    odom_from_world_ = at.inverse();
  }
  Pose2 start_{-3.0, -2.0, 0.2}, step_{0.06, 0, 0.02}, odom_from_world_;
  int64_t off_us_ = 0;
  testing::FlatWorld room_ = testing::small_room();
  process::LcmBus bus_;
  process::DropCounter heard_;
  TemporaryFolder folder_;
  std::vector<std::string> states_;
  std::vector<slam_reply_t> replies_;
  std::vector<int64_t> ordered_us_;
  slam_pose_t last_ = {};
  int poses_ = 0;
};

TEST_F(SlamOrders, AreObeyedWithoutARestartAndAnswered) {
  const auto slam = start();
  drive(0, 40);
  order(slam_command_t::SAVE, "hall");
  ASSERT_TRUE(hears("SAVE"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "hall" / "map.marco"));
  order(slam_command_t::SAVE, "../elsewhere");
  ASSERT_TRUE(hears("refused"));
  order(slam_command_t::LOCALIZE, "hall");
  ASSERT_TRUE(hears("LOCALIZE"));
  drive(5, 6);
  EXPECT_EQ(last_.status, int{slam_pose_t::STATUS_LOST});
  drive(6, 60);
  EXPECT_EQ(last_.status, int{slam_pose_t::STATUS_MATCHED});
  EXPECT_THAT((Pose2{last_.x_m, last_.y_m, last_.theta_rad}),
              IsNear(between(true_pose(0), true_pose(59)), 0.05, 0.02));
  order(slam_command_t::RESET, "");
  ASSERT_TRUE(hears("RESET"));
  ASSERT_EQ(replies_.size(), 4U);
  const std::vector<bool> done = {true, false, true, true};
  for (std::size_t i = 0; i < replies_.size(); ++i) {
    EXPECT_EQ(replies_[i].process, "marco-slam");
    EXPECT_EQ(replies_[i].command_utime, ordered_us_[i]);
    EXPECT_EQ(static_cast<bool>(replies_[i].ok), done[i]) << replies_[i].text;
  }
  EXPECT_EQ(replies_[0].path, at("hall"));
}

TEST_F(SlamOrders, AreGivenByACommandThatSaysWhatBecameOfThem) {
  const auto slam = start();
  drive(0, 40);
  const auto command = [&](std::vector<std::string> words) {
    Program program("marco-slam-order", std::move(words), at("order.out"));
    return program.wait(20);
  };
  EXPECT_EQ(command({"save", "hall"}), 0);
  EXPECT_THAT(files::read_whole_file(at("order.out")), HasSubstr("saved"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "hall" / "map.marco"));
  EXPECT_EQ(command({"localize", "nowhere"}), 1);
  EXPECT_THAT(files::read_whole_file(at("order.out")), HasSubstr("cannot be read"));
  EXPECT_EQ(command({"localize", "hall", "--at", "0", "0", "0"}), 0);
  drive(0, 3);
  EXPECT_EQ(last_.status, int{slam_pose_t::STATUS_MATCHED});
  EXPECT_EQ(command({"extend", "hall"}), 0);
  EXPECT_EQ(command({"pause"}), 0);
  EXPECT_EQ(command({"resume"}), 0);
  EXPECT_EQ(command({"reset"}), 0);
  EXPECT_EQ(command({"dance"}), 2);
  slam->signal(SIGTERM);
  slam->wait(5);
  EXPECT_EQ(command({"pause"}), 1);
  EXPECT_THAT(files::read_whole_file(at("order.out")), HasSubstr("no SLAM answers"));
}

// A recording's orders, played by LCM's own player, which leaves out nothing.
TEST_F(SlamOrders, OfYesterdayEraseNothingToday) {
  constexpr int64_t kDayUs = 86'400'000'000;
  constexpr int8_t kOrders = slam_command_t::EXTEND + 1;
  {
    files::EventLogWriter log(at("yesterday.lcm"));
    for (int8_t kind = 0; kind < kOrders; ++kind) {
      slam_command_t message = {};
      message.utime = process::wall_clock_us() - kDayUs + kind * 1000;
      message.command = kind;
      message.folder = "hall";
      log.write(channels::kSlamCommand, encode_message(message), Utime::from_us(message.utime));
    }
  }
  for (const char* name : {"marco-slam", "marco-line-slam"}) {
    const auto slam = start(name);
    drive(0, 20);
    const slam_pose_t before = last_;
    replies_.clear();
    Program player("lcm-logplayer", {at("yesterday.lcm")}, at("player.out"));
    for (int i = 0; i < 50 && replies_.size() < kOrders; ++i) bus_.handle_once(100);
    ASSERT_EQ(replies_.size(), std::size_t{kOrders}) << name;
    for (const slam_reply_t& reply : replies_) {
      EXPECT_THAT(reply.text, ::testing::StartsWith("refused: order is 1 days old"));
    }
    drive(20, 22);  // neither paused nor put elsewhere
    EXPECT_EQ(last_.status, int{slam_pose_t::STATUS_MATCHED});
    EXPECT_NEAR(std::hypot(last_.x_m - before.x_m, last_.y_m - before.y_m), 0.12, 0.03);
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "hall"));
    std::filesystem::remove(at("checkpoint"));
  }
}

TEST_F(SlamOrders, KilledItGoesOnFromItsCheckpointThoughScansPassedMeanwhile) {
  auto slam = start();
  drive(0, 40);
  // A checkpoint is written behind the scans, and a busy disk takes its time.
  for (int i = 0; i < 100 && !std::filesystem::exists(at("checkpoint")); ++i) bus_.handle_once(100);
  slam->signal(SIGKILL);
  slam->wait(5);
  slam = start();
  EXPECT_THAT(files::read_whole_file(at("slam.out")), HasSubstr("resumed from"));
  drive(48, 60);
  EXPECT_EQ(last_.status, int{slam_pose_t::STATUS_MATCHED});
  EXPECT_THAT((Pose2{last_.x_m, last_.y_m, last_.theta_rad}),
              IsNear(between(true_pose(0), true_pose(59)), 0.05, 0.02));
}

TEST_F(SlamOrders, EndedAndStartedElsewhereItIsLostUntilItHasFoundItself) {
  auto slam = start();
  drive(0, 40);
  slam->signal(SIGTERM);
  EXPECT_EQ(slam->wait(20), 0);
  EXPECT_TRUE(std::filesystem::exists(at("checkpoint.ended")));
  slam = start();
  Program second("marco-slam", {"--config", at("slam.toml")}, at("second.out"));
  EXPECT_EQ(second.wait(20), 1);
  EXPECT_THAT(files::read_whole_file(at("second.out")), HasSubstr("another process is using"));
  const Pose2 world_from_map = start_;
  switch_off_and_on({0.0, 0.0, 0.3});
  drive(0, 2);
  EXPECT_EQ(last_.status, int{slam_pose_t::STATUS_LOST});
  states_.clear();
  EXPECT_TRUE(hears("looking for the robot in the map"));
  order(slam_command_t::SAVE, "before");  // what it has is not lost meanwhile
  EXPECT_TRUE(hears("before: saved"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "before" / "map.marco"));
  drive(2, 55);
  EXPECT_EQ(last_.status, int{slam_pose_t::STATUS_MATCHED});
  EXPECT_THAT((Pose2{last_.x_m, last_.y_m, last_.theta_rad}),
              IsNear(between(world_from_map, true_pose(54)), 0.05, 0.02));
}

TEST_F(SlamOrders, StartedInAnotherBuildingItBeginsANewMapAndTheOldOneStays) {
  auto slam = start();
  drive(0, 40);
  for (int i = 0; i < 100 && !std::filesystem::exists(at("checkpoint")); ++i) bus_.handle_once(100);
  slam->signal(SIGKILL);
  slam->wait(5);
  room_ = {};
  room_.add_chain({{-7, -5}, {7, -5}, {7, 2}, {9, 2}, {9, 3}, {7, 3}, {7, 5}, {-7, 5}, {-7, -5}});
  room_.add_box(1.0, 1.0, 1.6, 1.4);
  step_ = {0.15, 0, 0.05};
  slam = start();
  switch_off_and_on(start_);
  drive(0, 150);
  EXPECT_EQ(last_.status, int{slam_pose_t::STATUS_MATCHED});
  EXPECT_THAT((Pose2{last_.x_m, last_.y_m, last_.theta_rad}),
              IsNear(between(true_pose(0), true_pose(149)), 0.1, 0.05));
  EXPECT_THAT(files::read_whole_file(at("slam.out")), HasSubstr("starting a new one"));
  std::string old;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    if (entry.path().filename().string().starts_with("before_")) old = entry.path().filename();
  }
  order(slam_command_t::LOCALIZE, old);
  EXPECT_TRUE(hears("relocalizing in")) << old;
}

}  // namespace
}  // namespace marco
