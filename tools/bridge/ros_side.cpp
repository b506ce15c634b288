#include "tools/bridge/ros_side.hpp"

#include <chrono>
#include <utility>

#include "recordings/ros/encode_messages.hpp"

namespace marco::bridge {
namespace {

constexpr const char* kMapFrame = "map";  // REP 105
constexpr uint32_t kMap = 1, kPose = 2, kPath = 3, kTransforms = 4;
// Into the future, as other localizers of ROS do: who asks for the transform of now finds it until
// the next scan. slam_toolbox's default.
constexpr Duration kHoldsFor = Duration::from_us(200'000);
constexpr Duration kOdometryReach = Duration::from_us(500'000);

int64_t ns_of(Utime utime) { return utime.us * 1000; }

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

RosOutput::RosOutput(std::function<bool(std::vector<uint8_t>)> send) : send_(std::move(send)) {}

std::optional<std::string> RosOutput::open(const foxglove::ServerInfo& server) {
  encoding_.clear();
  trouble_.clear();
  if (!server.capabilities.contains("clientPublish")) {
    trouble_ = "the robot's bridge accepts no messages (capability clientPublish)";
    return std::nullopt;
  }
  for (const char* encoding : {"cdr", "ros1"}) {
    if (server.encodings.contains(encoding)) encoding_ = encoding;
    if (!encoding_.empty()) break;
  }
  if (encoding_.empty()) {
    trouble_ = "the robot's bridge accepts neither cdr nor ros1";
    return std::nullopt;
  }
  const auto type = [this](const std::string& package, const std::string& name) {
    return package + (encoding_ == "cdr" ? "/msg/" : "/") + name;
  };
  return foxglove::advertise_text(
      {{kMap, "/map", encoding_, type("nav_msgs", "OccupancyGrid")},
       {kPose, "/slam_pose", encoding_, type("geometry_msgs", "PoseStamped")},
       {kPath, "/marco/path", encoding_, type("nav_msgs", "Path")},
       {kTransforms, "/tf", encoding_, type("tf2_msgs", "TFMessage")}});
}

void RosOutput::send(uint32_t channel, const std::vector<uint8_t>& payload) {
  send_(foxglove::data_message(channel, payload));
}

void RosOutput::note(const OdometrySample& odometry) {
  odometry_.add(odometry.utime, odometry.odom_from_robot);
}

void RosOutput::send_pose(const PoseEstimate& estimate) {
  if (encoding_.empty()) return;
  const ros::Header header{ns_of(estimate.utime), kMapFrame};
  send(kPose, ros::encode(encoding_, ros::PoseMessage{header, lift(estimate.world_from_robot)}));
  send_transform(estimate);
}

void RosOutput::send_transform(const PoseEstimate& estimate) {
  if (!frames_ || frames_->robot.empty()) return;
  ros::TransformMessage transform;
  transform.header = {ns_of(estimate.utime + kHoldsFor), kMapFrame};
  transform.child_frame_id = frames_->robot;
  transform.parent_from_child = lift(estimate.world_from_robot);
  if (!frames_->odom.empty()) {
    const auto odom_from_robot = odometry_.at(estimate.utime, kOdometryReach);
    if (!odom_from_robot) return;
    transform.child_frame_id = frames_->odom;
    transform.parent_from_child = lift(estimate.world_from_robot * odom_from_robot->inverse());
  }
  send(kTransforms, ros::encode(encoding_, std::vector<ros::TransformMessage>{transform}));
}

void RosOutput::send_map(const GridMap& map, Utime utime) {
  map_ = {map, utime};
  send_map_again();
}

void RosOutput::send_map_again() {
  if (encoding_.empty() || !map_) return;
  send(kMap, ros::encode(encoding_, ros::Header{ns_of(map_->second), kMapFrame}, map_->first));
}

void RosOutput::send_path(const Trajectory& path, Utime utime) {
  if (encoding_.empty()) return;
  std::vector<ros::PoseMessage> poses;
  poses.reserve(path.size());
  for (const StampedPose2& pose : path) {
    poses.push_back({{ns_of(pose.utime), kMapFrame}, lift(pose.world_from_robot)});
  }
  send(kPath, ros::encode(encoding_, ros::Header{ns_of(utime), kMapFrame}, poses));
}

RosSide::RosSide(const std::string& url,
                 const RosOptions& options,
                 process::DropCounter& drops,
                 std::function<void(const std::string&)> say)
    : url_(url),
      drops_(drops),
      say_(std::move(say)),
      input_(options,
             [this](const Sample& sample) {
               if (const auto* odometry = std::get_if<OdometrySample>(&sample)) {
                 output_.note(*odometry);
               }
               if (marco_ != nullptr) marco_->give(sample);
             }),
      output_([this](std::vector<uint8_t> message) {
        const bool sent = socket_.send_binary(std::move(message));
        if (!sent) drops_.count("not sent: the robot reads messages too slowly");
        return sent;
      }),
      socket_(parse_websocket_url(url),
              foxglove::kSubprotocols,
              {[this](const std::string& subprotocol) {
                 not_connected_.clear();
                 say_("connected to " + url_ + " (" + subprotocol + ")");
               },
               [this](std::string_view text) { count([&] { take_text(text); }); },
               [this](std::span<const uint8_t> message) { count([&] { take_binary(message); }); },
               [this](const std::string& why) {
                 const std::string now = "not connected to " + url_ + ": " + why;
                 if (now != not_connected_) say_(now + "; retrying every second");
                 not_connected_ = now;
                 input_.forget();
                 output_.close();
               }}) {}

void RosSide::count(const std::function<void()>& handle) {
  drops_.count_received();
  try {
    handle();
  } catch (const std::invalid_argument& bad_message) {
    drops_.count(bad_message.what());
  }
}

void RosSide::take_text(std::string_view text) {
  const foxglove::ServerText message = foxglove::parse_text(text);
  if (const auto* server = std::get_if<foxglove::ServerInfo>(&message)) {
    input_.forget();  // what a session before this one called its channels
    if (const auto topics = output_.open(*server)) {
      socket_.send_text(*topics);
      output_.send_map_again();
    } else {
      say_("nothing is sent back: " + output_.trouble());
    }
  } else if (const auto* advertised = std::get_if<foxglove::Advertised>(&message)) {
    const auto wanted = input_.advertised(advertised->channels);
    if (!wanted.empty()) socket_.send_text(foxglove::subscribe_text(wanted));
  } else if (const auto* gone = std::get_if<foxglove::Unadvertised>(&message)) {
    input_.unadvertised(gone->channels);
  } else if (const auto* status = std::get_if<foxglove::ServerStatus>(&message)) {
    if (status->level > 0) say_("the robot's bridge says: " + status->message);
  }
}

void RosSide::take_binary(std::span<const uint8_t> message) {
  const auto data = foxglove::parse_binary(message);
  if (!data) return;
  input_.take(*data, steady_s());
  for (const std::string& note : input_.take_notes()) say_(note);
  if (input_.frames()) output_.note_frames(*input_.frames());
}

std::string RosSide::state() const {
  if (!not_connected_.empty()) return not_connected_;
  return output_.trouble().empty() ? input_.state() : input_.state() + "; " + output_.trouble();
}

}  // namespace marco::bridge
