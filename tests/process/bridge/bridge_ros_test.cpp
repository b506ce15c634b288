// marco-bridge and a robot's foxglove_bridge, without ROS: what comes to Marco's programs, and what
// goes back.
#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/process_status_t.hpp"
#include "recordings/ros/messages.hpp"
#include "recordings/ros/wire_reader.hpp"
#include "tests/process/bridge/driven_room.hpp"
#include "tests/process/bridge/foxglove_stub.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/ros_wire.hpp"

namespace marco {
namespace {

using ::marco::testing::drive;
using ::marco::testing::DrivenRoom;
using ::marco::testing::FoxgloveStub;
using ::marco::testing::IsNear;
using ::marco::testing::Program;
using ::marco::testing::RosWriter;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr double kStartS = 1'700'000'000.0;
constexpr int kBeams = 180;
const Pose2 kBaseFromLaser{0.2, 0.05, 0.1};

class BridgeRos : public ::testing::Test {
 protected:
  BridgeRos()
      : bus_(""),
        bridge_("marco-bridge",
                {"ws://127.0.0.1:" + std::to_string(robot_.port())},
                (folder_.path() / "out").string()) {
    room_.start(0.5);
    bus_.subscribe<sensor_info_t>(channels::kSensorInfo, drops_,
                                  [this](const auto& info, auto&) { info_ = from_message(info); });
    bus_.subscribe<odometry_t>(channels::kOdometry, drops_, [this](const auto& odometry, auto&) {
      odometry_ = from_message(odometry);
    });
    bus_.subscribe_raw(channels::kLidarPattern, [this](const process::RawMessage& raw) {
      scan_ = std::get<LaserScan>(*decode_sample(std::string(raw.channel), raw.bytes));
      ++scans_;
    });
    bus_.subscribe<process_status_t>(channels::kProcessStatus, drops_,
                                     [this](const auto& status, auto&) { state_ = status.state; });
  }
  std::string outputs() const { return files::read_whole_file((folder_.path() / "out").string()); }

  // Greets the bridge, and takes note of what it subscribes and announces.
  void serve(const std::string& subprotocol, const std::string& encoding) {
    encoding_ = encoding;
    offered_ = robot_.accept(subprotocol);
    ASSERT_FALSE(offered_.empty()) << outputs();
    robot_.send_text(Json{
        {"op", "serverInfo"},
        {"name", "robot"},
        {"capabilities", {"clientPublish", "unknown"}},
        {"supportedEncodings", {encoding, "json"}},
        {"sessionId",
         subprotocol}}.dump());
    const std::string package = encoding == "cdr" ? "/msg/" : "/";
    const auto channel = [&](int id, const char* topic, const std::string& type) {
      Json json = {{"id", id},
                   {"topic", topic},
                   {"encoding", encoding},
                   {"schemaName", type},
                   {"schema", ""}};
      return json;
    };
    robot_.send_text(Json{{"op", "advertise"},
                          {"channels",
                           {channel(11, "/scan", "sensor_msgs" + package + "LaserScan"),
                            channel(12, "/odom", "nav_msgs" + package + "Odometry"),
                            channel(13, "/tf_static", "tf2_msgs" + package + "TFMessage"),
                            channel(14, "/camera", "sensor_msgs" + package + "Image")}}}
                         .dump());
    subscribed_.clear();
    announced_.clear();
    while (subscribed_.size() < 3 || announced_.size() < 4) {
      const auto message = robot_.receive(5.0);
      ASSERT_TRUE(message) << outputs();
      if (message->is_text) take_text(Json::parse(message->bytes));
    }
  }
  void take_text(const Json& json) {
    if (json.at("op") == "subscribe") {
      for (const Json& one : json.at("subscriptions")) {
        subscribed_[one.at("channelId").get<int>()] = one.at("id").get<uint32_t>();
      }
    } else if (json.at("op") == "advertise") {
      for (const Json& one : json.at("channels")) {
        announced_[one.at("id").get<uint32_t>()] = {one.at("topic").get<std::string>(),
                                                    one.at("schemaName").get<std::string>()};
        EXPECT_EQ(one.at("encoding"), encoding_);
      }
    }
  }

  RosWriter writer() const {
    return RosWriter(encoding_ == "cdr" ? RosWriter::Form::cdr : RosWriter::Form::ros1);
  }
  void say(int channel, double time_s, const RosWriter& payload) {
    std::vector<uint8_t> message{1};
    const auto append = [&message](uint64_t value, int bytes) {
      for (int i = 0; i < bytes; ++i) message.push_back(static_cast<uint8_t>(value >> (8 * i)));
    };
    append(subscribed_.at(channel), 4);
    append(static_cast<uint64_t>(std::llround(1e9 * time_s)), 8);
    message.insert(message.end(), payload.bytes().begin(), payload.bytes().end());
    robot_.send_binary(message);
  }
  RosWriter pose(RosWriter out, const Pose2& pose) const {
    out.number(pose.x_m).number(pose.y_m).number(0.0).number(0.0).number(0.0);
    return out.number(std::sin(0.5 * pose.theta_rad)).number(std::cos(0.5 * pose.theta_rad));
  }
  void say_place() {
    RosWriter out = writer();
    out.number(uint32_t{1}).header(kStartS, "base_link").text("laser");
    say(13, kStartS, pose(out, kBaseFromLaser));
  }
  void say_odometry(double time_s) {
    RosWriter out =
        pose(writer().header(kStartS + time_s, "odom").text("base_link"), room_.pose_at(time_s));
    out.numbers(std::vector<double>(36, 0.0)).numbers(std::vector<double>(6, 0.0));
    say(12, kStartS + time_s, out.numbers(std::vector<double>(36, 0.0)));
  }
  void say_scan(double time_s) {
    RosWriter out = writer().header(kStartS + time_s, "laser");
    const float step = static_cast<float>(std::numbers::pi / kBeams);
    out.numbers(std::vector<float>{-0.5F * kBeams * step, 0.5F * kBeams * step, step, 0.0F, 0.1F,
                                   0.1F, 20.0F});
    out.number(uint32_t{kBeams});
    for (int i = 0; i < kBeams; ++i) {
      const double bearing = (i - 0.5 * kBeams) * static_cast<double>(step);
      out.number(static_cast<float>(room_.range_m(time_s, bearing, kBaseFromLaser)));
    }
    say(11, kStartS + time_s, out.number(uint32_t{0}));
  }
  // Until scans come to Marco's programs.
  bool drives_until_scans_come() {
    return drive(24.0, [this](double time_s) {
      now_s_ = time_s;
      say_odometry(time_s);
      say_scan(time_s);
      while (bus_.handle_once(1)) {
      }
      return scans_ > 3;
    });
  }

  // What was said last may still be on its way.
  void receive_the_last() {
    const auto is_last = [this](Utime utime) {
      return std::abs((utime - Utime::from_seconds(kStartS + now_s_)).seconds()) < 1e-3;
    };
    for (int i = 0; i < 50 && !(is_last(scan_->utime) && is_last(odometry_->utime)); ++i) {
      bus_.handle_once(100);
    }
  }

  /// What the bridge publishes on a topic, within five seconds.
  std::string heard_on(const std::string& topic) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (std::chrono::steady_clock::now() < end) {
      const auto message = robot_.receive(1.0);
      if (!message || message->is_text || message->bytes.size() < 5) continue;
      const auto id = static_cast<uint8_t>(message->bytes[1]);
      if (message->bytes[0] == 1 && announced_.at(id).first == topic) {
        return message->bytes.substr(5);
      }
    }
    ADD_FAILURE() << "nothing on " << topic << "; " << outputs();
    return "";
  }
  ros::Message message_on(const std::string& topic, const std::string& type) {
    heard_ = heard_on(topic);
    topic_.type = type;
    topic_.encoding = encoding_;
    return {&topic_, 0, 0, {reinterpret_cast<const uint8_t*>(heard_.data()), heard_.size()}};
  }

  // As SLAM would.
  Pose2 send_slam_results() {
    PoseEstimate estimate;
    estimate.utime = Utime::from_seconds(kStartS + now_s_);
    estimate.world_from_robot = Pose2{1.0, 2.0, 0.5} * room_.pose_at(now_s_);
    estimate.status = PoseEstimate::Status::matched;
    GridMap map;
    map.origin_m = {-1.0, -2.0};
    map.resolution_m = 0.05;
    map.width_cells = 3;
    map.height_cells = 2;
    map.occupancy = {0, 50, 100, GridMap::kUnknown, 1, 2};
    for (const auto& tile : to_messages(map, estimate.utime, 1)) {
      bus_.publish(channels::kGridMap, tile);
    }
    bus_.publish(
        channels::kTrajectory,
        to_message(Trajectory{{estimate.utime, estimate.world_from_robot}}, estimate.utime, 1));
    bus_.publish(channels::kSlamPose, to_message(estimate));
    return estimate.world_from_robot;
  }
  void expect_results() {
    const Pose2 sent = send_slam_results();
    const auto path = message_on("/marco/path", "nav_msgs/Path");
    EXPECT_GT(path.bytes.size(), 60U);
    const ros::PoseMessage at =
        ros::decode_pose(message_on("/slam_pose", "geometry_msgs/PoseStamped"));
    EXPECT_EQ(at.header.frame_id, "map");
    EXPECT_THAT(flatten(at.pose), IsNear(sent, 1e-9, 1e-9));
    const auto transforms = ros::decode_transforms(message_on("/tf", "tf2_msgs/TFMessage"));
    ASSERT_EQ(transforms.size(), 1U);
    EXPECT_EQ(transforms[0].header.frame_id, "map");
    EXPECT_EQ(transforms[0].child_frame_id, "odom");
    EXPECT_THAT(flatten(transforms[0].parent_from_child), IsNear(Pose2{1.0, 2.0, 0.5}, 1e-6, 1e-6));
    expect_map(message_on("/map", "nav_msgs/OccupancyGrid"));
  }
  void expect_map(const ros::Message& message) const {
    auto in = ros::WireReader::of(encoding_, message.bytes);
    if (encoding_ == "ros1") in.number<uint32_t>();
    in.number<int32_t>();
    in.number<uint32_t>();
    EXPECT_EQ(in.string(), "map");
    in.number<int32_t>();
    in.number<uint32_t>();
    EXPECT_FLOAT_EQ(in.number<float>(), 0.05F);
    EXPECT_EQ(in.number<uint32_t>(), 3U);
    EXPECT_EQ(in.number<uint32_t>(), 2U);
    const std::vector<double> origin = in.numbers<double>(7);
    EXPECT_EQ(origin, (std::vector<double>{-1.0, -2.0, 0.0, 0.0, 0.0, 0.0, 1.0}));
    EXPECT_EQ(in.sequence<int8_t>(), (std::vector<int8_t>{0, 50, 100, -1, 1, 2}));
    in.finish();
  }

  DrivenRoom room_;
  TemporaryFolder folder_;
  FoxgloveStub robot_;
  process::LcmBus bus_;
  process::DropCounter drops_;
  Program bridge_;
  std::string offered_, encoding_, state_, heard_;
  ros::Topic topic_;
  std::map<int, uint32_t> subscribed_;                                 // channel to subscription
  std::map<uint32_t, std::pair<std::string, std::string>> announced_;  // topic and type by id
  std::optional<SensorInfo> info_;
  std::optional<OdometrySample> odometry_;
  std::optional<LaserScan> scan_;
  int scans_ = 0;
  double now_s_ = 0.0;
};

TEST_F(BridgeRos, CarriesSensorsToMarcoAndMapPoseAndPathBackAgainAfterEachLoss) {
  for (const bool is_ros2 : {true, false}) {
    SCOPED_TRACE(is_ros2 ? "ROS 2" : "ROS 1");
    scans_ = 0;
    // Servers of one kind know only one of the two names.
    ASSERT_NO_FATAL_FAILURE(
        serve(is_ros2 ? "foxglove.sdk.v1" : "foxglove.websocket.v1", is_ros2 ? "cdr" : "ros1"));
    EXPECT_THAT(offered_, HasSubstr("foxglove.sdk.v1"));
    EXPECT_THAT(offered_, HasSubstr("foxglove.websocket.v1"));
    EXPECT_FALSE(subscribed_.contains(14));  // of no use here
    say_place();
    ASSERT_TRUE(drives_until_scans_come()) << outputs();
    receive_the_last();
    EXPECT_THAT(flatten(info_->parent_from_sensor), IsNear(kBaseFromLaser, 1e-9, 1e-9));
    EXPECT_NEAR(info_->range_max_m, 20.0, 1e-6);
    // Nanoseconds become microseconds.
    EXPECT_NEAR((scan_->utime - Utime::from_seconds(kStartS + now_s_)).seconds(), 0.0, 1.5e-6);
    EXPECT_EQ(scan_->size(), static_cast<std::size_t>(kBeams));
    EXPECT_THAT(odometry_->odom_from_robot, IsNear(room_.pose_at(now_s_), 1e-9, 1e-9));
    expect_results();
    robot_.hang_up();
  }
  for (int i = 0; i < 40 && state_.find("not connected") == std::string::npos; ++i) {
    bus_.handle_once(100);
  }
  EXPECT_THAT(state_, HasSubstr("not connected"));
}

}  // namespace
}  // namespace marco
