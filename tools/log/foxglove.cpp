#include "tools/log/foxglove.hpp"

#include <algorithm>
#include <limits>

#include "bot_core/image_t.hpp"
#include "bot_core/pose_t.hpp"
#include "common/regular_scan.hpp"
#include "lcm_tools/log/export_json_lines.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/finite_pose.hpp"
#include "lcmtypes/stamp.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "recordings/foreign_messages.hpp"
#include "web/foxglove/grid.hpp"
#include "web/foxglove/messages.hpp"

namespace marco::logs {
namespace {

using lcm_schema::is_a;

template <class Message>
std::optional<Message> decode_as(std::span<const uint8_t> bytes) {
  Message message{};
  const int size = static_cast<int>(bytes.size());
  if (!is_a<Message>(bytes) || message.decode(bytes.data(), 0, size) < 0) return std::nullopt;
  return message;
}

// What LCM allows: anybody may have sent another.
bool is_channel_name(const std::string& name) {
  return !name.empty() && name.size() < 64 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

FoxgloveTranslator::FoxgloveTranslator(const LogInfo& log) : frames_(log) {
  constexpr int64_t kNoticedUs = 500000;
  for (const ChannelInfo& channel : log.channels) {
    if (!channel.clock || std::abs(channel.clock->offset.us) < kNoticedUs) continue;
    shifts_us_[channel.name] = channel.clock->offset.us;
  }
}

int64_t FoxgloveTranslator::shifted_us(std::string_view channel, int64_t utime_us) const {
  const auto shift = shifts_us_.find(channel);
  int64_t us = utime_us;
  if (shift != shifts_us_.end() && __builtin_add_overflow(us, shift->second, &us)) us = 0;
  return us;
}

std::string FoxgloveTranslator::in_frame(std::string_view channel,
                                         int64_t utime_us,
                                         const std::string& frame) const {
  return foxglove::in_frame(shifted_us(channel, utime_us), frame);
}

// As lcmtypes/lcm_log_reader: a laser that SENSOR_INFO describes is one of ours.
const ForeignChannel* FoxgloveTranslator::foreign_laser(const std::string& channel,
                                                        uint64_t fingerprint) const {
  if (infos_.contains(channel)) return nullptr;
  return entry_of(foreign_, channel, lcm_schema::fingerprint_text(fingerprint));
}

// A sensor has a frame of its own once it is known where that lies.
std::string FoxgloveTranslator::frame_of(const std::string& channel,
                                         const std::string& otherwise) const {
  return infos_.contains(channel) ? channel : otherwise;
}

AddedMessage FoxgloveTranslator::pose_message(const std::string& channel,
                                              int64_t utime_us,
                                              const std::string& frame,
                                              const Pose3& pose) const {
  return {channel + "/PoseInFrame", "foxglove.PoseInFrame",
          foxglove::pose_in_frame(shifted_us(channel, utime_us), frame, pose)};
}

AddedMessage FoxgloveTranslator::transform_message(const std::string& channel,
                                                   int64_t utime_us,
                                                   const foxglove::Transform& transform) const {
  return {channel + "/FrameTransform", "foxglove.FrameTransform",
          foxglove::frame_transform(shifted_us(channel, utime_us), transform)};
}

std::string FoxgloveTranslator::remark() const {
  const int64_t count = grids_.left_out();
  return count == 0
             ? ""
             : std::to_string(count) + " maps are too large to draw: only their tiles were written";
}

std::vector<AddedMessage> FoxgloveTranslator::translate(const DecodedEvent& event) {
  std::vector<AddedMessage> messages =
      grid_messages(grids_.finished(bounded(event.head.event_time)));
  for (AddedMessage& message : translate_message(event)) messages.push_back(std::move(message));
  return messages;
}

std::vector<AddedMessage> FoxgloveTranslator::translate_message(const DecodedEvent& event) {
  // lcm-gen's decoders make room for whatever length a message claims: only whole ones get there.
  if (event.structure < 0) return {};
  const std::string channel(event.head.channel);
  try {
    if (const auto planar = decode_as<bot_core::planar_lidar_t>(event.bytes)) {
      return translate_scan(from_message(*planar, channel), bot_core::planar_lidar_t::getHash());
    }
    if (const auto raw = decode_as<lidar_raw_t>(event.bytes)) {
      return translate_scan(from_message(*raw, channel), lidar_raw_t::getHash());
    }
    if (is_a<bot_core::image_t>(event.bytes)) return translate_image(event);
    for (const auto translate_as :
         {&FoxgloveTranslator::translate_info, &FoxgloveTranslator::translate_grid,
          &FoxgloveTranslator::translate_pose, &FoxgloveTranslator::translate_scene}) {
      auto messages = (this->*translate_as)(event, channel);
      if (!messages.empty()) return messages;
    }
    return translate_path(event, channel);
  } catch (const std::invalid_argument&) {
    return {};  // a message that contradicts itself
  }
}

// Where sensors sit, and how the pan-tilt stands.
std::vector<AddedMessage> FoxgloveTranslator::translate_info(const DecodedEvent& event,
                                                             const std::string& channel) {
  if (const auto message = decode_as<sensor_info_t>(event.bytes)) {
    const SensorInfo info = from_message(*message);
    infos_[info.channel] = info;
    if (info.channel == channels::kPanTiltState) return {};  // its plate moves
    if (!is_channel_name(info.channel)) return {};
    AddedMessage transform =
        transform_message(channel, message->utime, RobotFrames::of_sensor(info));
    transform.topic = info.channel + "/FrameTransform";
    return {transform};
  }
  if (const auto message = decode_as<pantilt_state_t>(event.bytes)) {
    const auto base = infos_.find(channel);
    if (base == infos_.end()) return {};
    const foxglove::Transform plate = RobotFrames::of_plate(base->second, from_message(*message));
    return {transform_message(channel, message->utime, plate)};
  }
  return {};
}

std::vector<AddedMessage> FoxgloveTranslator::translate_scan(LaserScan scan,
                                                             uint64_t fingerprint) const {
  const ForeignChannel* foreign = foreign_laser(scan.channel, fingerprint);
  if (foreign != nullptr) settle_direction(scan, *foreign);
  scan = make_regular(scan, std::numeric_limits<float>::infinity());
  scan.utime = Utime::from_us(shifted_us(scan.channel, scan.utime.us));
  return {{scan.channel + "/LaserScan", "foxglove.LaserScan",
           foxglove::laser_scan(scan, frame_of(scan.channel, "robot"))}};
}

std::vector<AddedMessage> FoxgloveTranslator::translate_grid(const DecodedEvent& event,
                                                             const std::string& channel) {
  if (auto tile = decode_as<grid_map_t>(event.bytes)) {
    return grid_messages(grids_.add(channel, *tile, bounded(event.head.event_time)));
  }
  if (lcm_schema::fingerprint_of(event.bytes) != foxglove::kMbotGrid) return {};
  const int utime = event.tree.child(0, "utime");
  const int64_t utime_us =
      utime < 0 ? 0 : event.tree.integer(event.tree.nodes[static_cast<std::size_t>(utime)]);
  const std::string json = foxglove::mbot_grid_json(event.tree);
  if (json.empty()) return {};
  return {{channel + "/Grid", "foxglove.Grid", in_frame(channel, utime_us, "world") + json}};
}

std::vector<AddedMessage> FoxgloveTranslator::grid_messages(
    const std::vector<JoinedGrid>& grids) const {
  std::vector<AddedMessage> messages;
  for (const JoinedGrid& grid : grids) {
    messages.push_back(
        {grid.channel + "/Grid", "foxglove.Grid",
         in_frame(grid.channel, grid.utime_us, "world") + foxglove::floor_plan_json(grid.map),
         grid.event_time});
  }
  return messages;
}

std::vector<AddedMessage> FoxgloveTranslator::translate_scene(const DecodedEvent& event,
                                                              const std::string& channel) {
  std::string json;
  if (const auto tile = decode_as<mesh_t>(event.bytes)) {
    json = scenes_.json(channel, foxglove::stamp_json(shifted_us(channel, tile->utime)), "world",
                        *tile);
  } else if (const auto walls = decode_as<line_map_t>(event.bytes)) {
    json = foxglove::walls_scene(shifted_us(channel, walls->utime), "world", from_message(*walls));
  } else if (const auto loops = decode_as<loop_closures_t>(event.bytes)) {
    json = foxglove::loops_scene(shifted_us(channel, loops->utime), "world", from_message(*loops));
  }
  if (json.empty()) return {};
  return {{channel + "/SceneUpdate", "foxglove.SceneUpdate", std::move(json)}};
}

std::vector<AddedMessage> FoxgloveTranslator::translate_path(const DecodedEvent& event,
                                                             const std::string& channel) const {
  const auto message = decode_as<trajectory_t>(event.bytes);
  if (!message) return {};
  return {{channel + "/PosesInFrame", "foxglove.PosesInFrame",
           foxglove::poses_in_frame(shifted_us(channel, message->utime), "world",
                                    from_message(*message))}};
}

std::vector<AddedMessage> FoxgloveTranslator::translate_pose(const DecodedEvent& event,
                                                             const std::string& channel) {
  // The pose itself, and what it says of the robot's frames.
  const auto answer = [&](int64_t utime_us, const std::string& frame, const Pose2& pose) {
    std::vector<AddedMessage> messages = {pose_message(channel, utime_us, frame, lift(pose))};
    const Utime utime = stamp_of(utime_us);
    const bool slam = is_a<slam_pose_t>(event.bytes) || channel == channels::kSlamPose;
    const auto transform = frame == "odom" ? frames_.add_odometry(channel, utime, pose)
                           : slam          ? frames_.add_slam(channel, utime, pose)
                                           : std::nullopt;
    if (transform) messages.push_back(transform_message(channel, utime_us, *transform));
    return messages;
  };
  constexpr const char* kNoPlace = "invalid pose";
  if (const auto slam = decode_as<slam_pose_t>(event.bytes)) {
    return answer(slam->utime, "world",
                  finite_pose(slam->x_m, slam->y_m, slam->theta_rad, kNoPlace));
  }
  if (const auto pose = decode_as<pose2_t>(event.bytes)) {
    return answer(pose->utime, "world", from_message(*pose).world_from_robot);
  }
  if (const auto odometry = decode_as<odometry_t>(event.bytes)) {
    return answer(odometry->utime, "odom", from_message(*odometry).odom_from_robot);
  }
  if (const auto pose = decode_as<mbot_pose2d_t>(event.bytes)) {
    const bool odom = channel.find("ODOM") != std::string::npos;
    return answer(pose->utime, odom ? "odom" : "world",
                  finite_pose(static_cast<double>(pose->x), static_cast<double>(pose->y),
                              static_cast<double>(pose->theta), kNoPlace));
  }
  if (const auto pose = decode_as<bot_core::pose_t>(event.bytes)) {
    const double(&q)[4] = pose->orientation;
    Pose3 local_from_body = Pose3::Identity();
    local_from_body.linear() =
        Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    local_from_body.translation() = Eigen::Vector3d(pose->pos);
    return {pose_message(channel, pose->utime, "local", local_from_body)};
  }
  return {};
}

std::vector<AddedMessage> FoxgloveTranslator::translate_image(const DecodedEvent& event) const {
  const auto image = decode_as<bot_core::image_t>(event.bytes);
  if (!image) return {};
  const std::string channel(event.head.channel);
  const std::string head = in_frame(channel, image->utime, frame_of(channel, "camera"));
  if (image->pixelformat == bot_core::image_t::PIXEL_FORMAT_MJPEG) {
    return {{channel + "/CompressedImage", "foxglove.CompressedImage",
             foxglove::compressed_image(shifted_us(channel, image->utime),
                                        frame_of(channel, "camera"), image->data)}};
  }
  const char* encoding = image->pixelformat == bot_core::image_t::PIXEL_FORMAT_GRAY  ? "mono8"
                         : image->pixelformat == bot_core::image_t::PIXEL_FORMAT_RGB ? "rgb8"
                         : image->pixelformat == bot_core::image_t::PIXEL_FORMAT_BGR ? "bgr8"
                                                                                     : nullptr;
  if (encoding == nullptr || image->width <= 0 || image->height <= 0) return {};
  return {{channel + "/RawImage", "foxglove.RawImage",
           head + R"(,"width":)" + std::to_string(image->width) + R"(,"height":)" +
               std::to_string(image->height) + R"(,"encoding":")" + encoding + R"(","step":)" +
               std::to_string(image->row_stride) + R"(,"data":")" + to_base64(image->data) +
               "\"}"}};
}

}  // namespace marco::logs
