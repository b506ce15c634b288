#include "tools/log/foxglove.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <regex>

#include "bot_core/image_t.hpp"
#include "bot_core/pose_t.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "tools/log/export_json_lines.hpp"
#include "tools/log/regular_scan.hpp"

namespace marco::logs {
namespace {

// Types are known by their fingerprints: other stacks' types of the same fields are the same.
template <class Message>
bool is_a(std::span<const uint8_t> bytes) {
  const auto fingerprint = lcm_schema::fingerprint_of(bytes);
  return fingerprint && *fingerprint == static_cast<uint64_t>(Message::getHash());
}

template <class Message>
std::optional<Message> decode_as(std::span<const uint8_t> bytes) {
  Message message{};
  const int size = static_cast<int>(bytes.size());
  if (!is_a<Message>(bytes) || message.decode(bytes.data(), 0, size) < 0) return std::nullopt;
  return message;
}

template <class Number>
std::string number(Number value) {
  if (!std::isfinite(value)) return "0";
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string vector_json(double x, double y, double z) {
  return R"({"x":)" + number(x) + R"(,"y":)" + number(y) + R"(,"z":)" + number(z) + "}";
}

std::string quaternion_json(const Eigen::Quaterniond& q) {
  return R"({"x":)" + number(q.x()) + R"(,"y":)" + number(q.y()) + R"(,"z":)" + number(q.z()) +
         R"(,"w":)" + number(q.w()) + "}";
}

std::string pose_json(const Pose3& pose) {
  const Eigen::Vector3d& at = pose.translation();
  return R"({"position":)" + vector_json(at.x(), at.y(), at.z()) + R"(,"orientation":)" +
         quaternion_json(Eigen::Quaterniond(pose.linear())) + "}";
}

struct Grid {
  double x_m = 0.0, y_m = 0.0, cell_m = 0.0;
  int64_t columns = 0;
  int numeric_type = 1;  // UINT8
  std::span<const uint8_t> cells;
};

// Behind stamp and frame.
std::string grid_json(const Grid& grid) {
  const std::string cell = number(grid.cell_m);
  return R"(,"pose":)" + pose_json(lift({grid.x_m, grid.y_m, 0.0})) + R"(,"column_count":)" +
         std::to_string(grid.columns) + R"(,"cell_size":{"x":)" + cell + R"(,"y":)" + cell +
         R"(},"row_stride":)" + std::to_string(grid.columns) +
         R"(,"cell_stride":1,"fields":[{"name":"occupancy","offset":0,"type":)" +
         std::to_string(grid.numeric_type) + R"(}],"data":")" + to_base64(grid.cells) + "\"}";
}

double field(const lcm_schema::Tree& tree, std::string_view name) {
  const int node = tree.child(0, name);
  return node < 0 ? std::numeric_limits<double>::quiet_NaN()
                  : tree.number(tree.nodes[static_cast<std::size_t>(node)]);
}

constexpr uint64_t kMbotGrid = 0xd5447e494a66cc92;  // mbot_lcm_msgs.occupancy_grid_t

}  // namespace

FoxgloveTranslator::FoxgloveTranslator(const LogInfo& clocks) {
  constexpr int64_t kNoticedUs = 500000;
  for (const ChannelInfo& channel : clocks.channels) {
    if (!channel.clock || std::abs(channel.clock->offset.us) < kNoticedUs) continue;
    shifts_us_[channel.name] = channel.clock->offset.us;
  }
}

std::string FoxgloveTranslator::stamp(std::string_view channel, int64_t utime_us) const {
  const auto shift = shifts_us_.find(channel);
  int64_t us = utime_us;
  if (shift != shifts_us_.end() && __builtin_add_overflow(us, shift->second, &us)) us = 0;
  us = std::max<int64_t>(0, us);
  return R"("timestamp":{"sec":)" + std::to_string(us / 1000000) + R"(,"nsec":)" +
         std::to_string(us % 1000000 * 1000) + "}";
}

std::string FoxgloveTranslator::in_frame(std::string_view channel,
                                         int64_t utime_us,
                                         const std::string& frame) const {
  return "{" + stamp(channel, utime_us) + R"(,"frame_id":")" + frame + "\"";
}

// As lcmtypes/lcm_log_reader: a laser that SENSOR_INFO describes is one of ours.
bool FoxgloveTranslator::is_clockwise(const std::string& channel, uint64_t fingerprint) const {
  if (infos_.contains(channel)) return false;
  char hex[17];
  std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(fingerprint));
  for (const ForeignChannel& entry : foreign_.channels) {
    if (entry.fingerprint == hex &&
        std::regex_match(channel, std::regex(entry.channel, std::regex::extended))) {
      return entry.clockwise;
    }
  }
  return false;
}

std::vector<FoxgloveMessage> FoxgloveTranslator::translate(const DecodedEvent& event) {
  // lcm-gen's decoders make room for whatever length a message claims: only whole ones get there.
  if (event.structure < 0) return {};
  const std::string channel(event.head.channel);
  try {
    if (const auto info = decode_as<sensor_info_t>(event.bytes)) {
      infos_[info->channel] = from_message(*info);
      return {};
    }
    if (const auto planar = decode_as<bot_core::planar_lidar_t>(event.bytes)) {
      return translate_scan(from_message(*planar, channel), bot_core::planar_lidar_t::getHash());
    }
    if (const auto raw = decode_as<lidar_raw_t>(event.bytes)) {
      return translate_scan(from_message(*raw, channel), lidar_raw_t::getHash());
    }
    if (is_a<bot_core::image_t>(event.bytes)) return translate_image(event);
    auto grid = translate_grid(event, channel);
    return grid.empty() ? translate_pose(event, channel) : grid;
  } catch (const std::invalid_argument&) {
    return {};  // a message that contradicts itself
  }
}

std::vector<FoxgloveMessage> FoxgloveTranslator::translate_scan(LaserScan scan,
                                                                uint64_t fingerprint) const {
  if (is_clockwise(scan.channel, fingerprint)) {
    for (float& bearing : scan.bearings_rad) bearing = -bearing;
    scan.first_bearing_rad = -scan.first_bearing_rad;
    scan.bearing_step_rad = -scan.bearing_step_rad;
  }
  scan = make_regular(scan, std::numeric_limits<float>::infinity());
  const auto info = infos_.find(scan.channel);
  const bool on_robot = info != infos_.end() && info->second.mount == SensorInfo::Mount::robot;
  const Pose3 pose = on_robot ? info->second.parent_from_sensor : Pose3::Identity();
  // Where the laser sits is known for the robot's own; others have a frame of their own.
  const bool own_frame = info != infos_.end() && !on_robot;
  const double last = static_cast<double>(scan.size()) - 1.0;
  std::string json =
      in_frame(scan.channel, scan.utime.us, own_frame ? "plate" : "robot") + R"(,"pose":)" +
      pose_json(pose) + R"(,"start_angle":)" + number(scan.first_bearing_rad) + R"(,"end_angle":)" +
      number(scan.first_bearing_rad + last * scan.bearing_step_rad) + R"(,"ranges":[)";
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    if (beam > 0) json += ',';
    json += number(scan.ranges_m[beam]);
  }
  json += R"(],"intensities":[]})";
  return {{scan.channel + "/LaserScan", "foxglove.LaserScan", std::move(json)}};
}

std::vector<FoxgloveMessage> FoxgloveTranslator::translate_grid(const DecodedEvent& event,
                                                                const std::string& channel) {
  Grid grid;
  if (const auto tile = decode_as<grid_map_t>(event.bytes)) {
    from_message(*tile);  // refuses what contradicts itself
    grid = {tile->origin_x_m, tile->origin_y_m, tile->resolution_m, tile->width_cells, 1,
            tile->occupancy};
    auto& [revision, count] = tiles_[channel];
    count = revision == tile->revision ? count + 1 : 0;
    revision = tile->revision;
    return {{channel + "/Grid_" + std::to_string(count), "foxglove.Grid",
             in_frame(channel, tile->utime, "world") + grid_json(grid)}};
  }
  if (lcm_schema::fingerprint_of(event.bytes) != kMbotGrid) return {};
  const lcm_schema::Tree& tree = event.tree;
  const int cells = tree.child(0, "cells");
  if (cells < 0) return {};
  const lcm_schema::Node& node = tree.nodes[static_cast<std::size_t>(cells)];
  const int utime = tree.child(0, "utime");
  const int64_t utime_us =
      utime < 0 ? 0 : tree.integer(tree.nodes[static_cast<std::size_t>(utime)]);
  grid.x_m = field(tree, "origin_x");
  grid.y_m = field(tree, "origin_y");
  grid.cell_m = field(tree, "meters_per_cell");
  grid.columns = static_cast<int64_t>(field(tree, "width"));
  grid.numeric_type = 2;  // INT8
  grid.cells = tree.message.subspan(node.offset, node.bytes);
  if (grid.columns <= 0 || !(grid.cell_m > 0.0)) return {};
  return {
      {channel + "/Grid", "foxglove.Grid", in_frame(channel, utime_us, "world") + grid_json(grid)}};
}

std::vector<FoxgloveMessage> FoxgloveTranslator::translate_pose(const DecodedEvent& event,
                                                                const std::string& channel) const {
  const std::string topic = channel + "/PoseInFrame";
  const auto answer = [&](int64_t utime, const std::string& frame, const Pose3& pose) {
    return std::vector<FoxgloveMessage>{
        {topic, "foxglove.PoseInFrame",
         in_frame(channel, utime, frame) + R"(,"pose":)" + pose_json(pose) + "}"}};
  };
  if (const auto slam = decode_as<slam_pose_t>(event.bytes)) {
    const Pose3 pose = lift({slam->x_m, slam->y_m, slam->theta_rad});
    auto messages = answer(slam->utime, "world", pose);
    const Eigen::Vector3d& at = pose.translation();
    messages.push_back(
        {channel + "/FrameTransform", "foxglove.FrameTransform",
         "{" + stamp(channel, slam->utime) +
             R"(,"parent_frame_id":"world","child_frame_id":"robot","translation":)" +
             vector_json(at.x(), at.y(), at.z()) + R"(,"rotation":)" +
             quaternion_json(Eigen::Quaterniond(pose.linear())) + "}"});
    return messages;
  }
  if (const auto pose = decode_as<pose2_t>(event.bytes)) {
    return answer(pose->utime, "world", lift({pose->x_m, pose->y_m, pose->theta_rad}));
  }
  if (const auto odometry = decode_as<odometry_t>(event.bytes)) {
    return answer(odometry->utime, "odom",
                  lift({odometry->x_m, odometry->y_m, odometry->theta_rad}));
  }
  if (const auto pose = decode_as<mbot_pose2d_t>(event.bytes)) {
    const bool odom = channel.find("ODOM") != std::string::npos;
    return answer(pose->utime, odom ? "odom" : "world",
                  lift({static_cast<double>(pose->x), static_cast<double>(pose->y),
                        static_cast<double>(pose->theta)}));
  }
  if (const auto pose = decode_as<bot_core::pose_t>(event.bytes)) {
    const double(&q)[4] = pose->orientation;
    Pose3 local_from_body = Pose3::Identity();
    local_from_body.linear() =
        Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    local_from_body.translation() = Eigen::Vector3d(pose->pos);
    return answer(pose->utime, "local", local_from_body);
  }
  return {};
}

std::vector<FoxgloveMessage> FoxgloveTranslator::translate_image(const DecodedEvent& event) const {
  const auto image = decode_as<bot_core::image_t>(event.bytes);
  if (!image) return {};
  const std::string channel(event.head.channel);
  const std::string head = in_frame(channel, image->utime, "camera");
  if (image->pixelformat == bot_core::image_t::PIXEL_FORMAT_MJPEG) {
    return {{channel + "/CompressedImage", "foxglove.CompressedImage",
             head + R"(,"data":")" + to_base64(image->data) + R"(","format":"jpeg"})"}};
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
