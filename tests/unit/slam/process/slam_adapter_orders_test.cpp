// A SlamAdapter that takes orders.
#include <gmock/gmock.h>

#include <cmath>

#include "slam/process/map_folder.hpp"
#include "tests/support/matchers.hpp"
#include "tests/unit/slam/process/slam_adapter_fixture.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::complaint;
using ::testing::HasSubstr;
using SlamAdapterOrders = SlamAdapterFixture;

std::string text_of(const std::optional<slam_reply_t>& reply) { return reply ? reply->text : ""; }

TEST_F(SlamAdapterOrders, ItSavesLocalizesPausesAndForgetsByOrder) {
  SlamAdapterOptions options;
  options.maps_folder = folder_.path().string();
  process::BatchBus bus;
  SlamAdapter slam(bus, options);
  for (std::size_t i = 0; i < 61; ++i) send(bus, samples_[i]);
  order(bus, slam_command_t::SAVE, "hall");
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("saved"));
  EXPECT_EQ(text_of(slam.take_reply()), "");
  for (const char* name : {"map.marco", "map_1.pgm", "map.yaml", "trajectory.tum"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "hall" / name)) << name;
  }
  EXPECT_EQ(load_map_folder(folder_.path() / "hall").slam.path.scans.size(), 30U);

  order(bus, slam_command_t::PAUSE);
  for (std::size_t i = 61; i < 63; ++i) send(bus, samples_[i]);
  EXPECT_EQ(slam.live_trajectory().size(), 30U);
  EXPECT_EQ(slam.drops().by_cause().at("paused"), 1);
  order(bus, slam_command_t::RESUME);
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("PAUSE"));
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("RESUME"));

  order(bus, slam_command_t::LOCALIZE, "hall");
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("relocalizing"));
  EXPECT_THAT(slam.state_line(), HasSubstr("not found in the map yet"));
  for (std::size_t i = 1; i < samples_.size(); ++i) send(bus, samples_[i]);
  EXPECT_THAT(slam.state_line(), HasSubstr("localized"));
  order(bus, slam_command_t::SAVE, "hall");
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("refused"));

  order(bus, slam_command_t::RESET);
  EXPECT_EQ(slam.slam().key_count(), 0U);
  EXPECT_EQ(slam.session().mode(), MappingSession::Mode::mapping);
}

TEST_F(SlamAdapterOrders, WhatIsRefusedLeavesTheMapAsItIs) {
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
    EXPECT_THAT(text_of(slam.take_reply()),
                HasSubstr("refused: SET_POSE: the pose must be finite"));
  }
  for (const char* folder : {"hall", "nowhere", "../hall", ""}) {
    order(bus, slam_command_t::LOCALIZE, folder);
    EXPECT_NE(text_of(slam.take_reply()), "");
  }
  folder_.write("file", "");
  order(bus, slam_command_t::SAVE, "file");
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("failed: "));
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

TEST_F(SlamAdapterOrders, OrdersThatLeadOutOfTheMapsFolderOrNowhereAreRefused) {
  SlamAdapterOptions options;
  options.maps_folder = folder_.path().string();
  process::BatchBus bus;
  SlamAdapter slam(bus, options);
  for (const char* folder : {"/etc", "../elsewhere", "a/../../b", ""}) {
    order(bus, slam_command_t::SAVE, folder);
    EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("refused")) << folder;
  }
  order(bus, slam_command_t::LOCALIZE, "no such map");
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("cannot be read"));
  order(bus, 77);
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("not a command"));
  folder_.write("map.marco", "something else");
  EXPECT_THAT(complaint([&] { load_map_folder(folder_.path()); }),
              HasSubstr("map.marco: is no MARCOMAP file"));
}

TEST_F(SlamAdapterOrders, WithoutAMapNothingIsSavedAndTheReasonIsSaid) {
  SlamAdapterOptions options;
  options.maps_folder = folder_.path().string();
  process::BatchBus bus;
  SlamAdapter slam(bus, options);
  std::get<SensorInfo>(samples_[0]).parent_from_sensor =
      make_pose3({0.1, 0.0, 0.3}) * Pose3(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitY()));
  for (std::size_t i = 0; i < 20; ++i) send(bus, samples_[i]);
  EXPECT_THAT(slam.state_line(), HasSubstr("no map: the laser is not level"));
  order(bus, slam_command_t::SAVE, "hall");
  EXPECT_THAT(text_of(slam.take_reply()), HasSubstr("refused: SAVE: there is no map yet"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "hall"));
}

TEST_F(SlamAdapterOrders, ASavedMapGrowsByWhatIsDrivenAfterExtend) {
  SlamAdapterOptions options;
  options.maps_folder = folder_.path().string();
  process::BatchBus bus;
  SlamAdapter first(bus, options);
  for (const Sample& sample : samples_) send(bus, sample);
  order(bus, slam_command_t::SAVE, "hall");
  ASSERT_TRUE(first.take_reply()->ok);
  const std::size_t scans = first.slam().trajectory().size();

  process::BatchBus another_day;
  SlamAdapter second(another_day, options);
  order(another_day, slam_command_t::EXTEND, "hall");
  const auto reply = second.take_reply();
  ASSERT_TRUE(reply && reply->ok) << text_of(reply);
  EXPECT_EQ(reply->path, (folder_.path() / "hall").string());
  // Alone, the new scans would take the saved map's place.
  send(another_day, samples_[0]);
  send(another_day, samples_[1]);
  send(another_day, samples_[2]);
  order(another_day, slam_command_t::SAVE, "hall");
  EXPECT_THAT(text_of(second.take_reply()),
              HasSubstr("refused: SAVE: the robot has not yet been found"));
  EXPECT_EQ(load_map_folder(folder_.path() / "hall").slam.path.scans.size(), scans);
  for (std::size_t i = 3; i < samples_.size(); ++i) send(another_day, samples_[i]);
  ASSERT_TRUE(second.session().joined());
  order(another_day, slam_command_t::SAVE, "hall");
  ASSERT_TRUE(second.take_reply()->ok);
  EXPECT_GT(load_map_folder(folder_.path() / "hall").slam.path.scans.size(), scans + 50);
}

}  // namespace
}  // namespace marco::slam
