#include "recordings/foreign_messages.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "bot_core/pose_t.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"
#include "lcm_tools/files/channel_pattern.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/stamp.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "marco/ros_laser_scan_t.hpp"
#include "marco/ros_odometry_t.hpp"
#include "marco/ros_pose_stamped_t.hpp"

namespace marco {
namespace {

constexpr const char* kUndecodable = "undecodable";

struct StampedPose {
  Utime utime;
  Pose2 pose;
};

int64_t utime_us_of(const ros_header_t& header) {
  return int64_t{header.stamp.sec} * 1'000'000 + header.stamp.nsec / 1000;
}

StampedPose flat(const ros_header_t& header, const ros_pose_t& pose) {
  const ros_quaternion_t& q = pose.orientation;
  return {stamp_of(utime_us_of(header)),
          {pose.position.x, pose.position.y, yaw_of_quaternion(q.w, q.x, q.y, q.z)}};
}

StampedPose pose_in(std::span<const uint8_t> bytes) {
  if (const auto pose = decode_message<mbot_pose2d_t>(bytes)) {
    return {stamp_of(pose->utime),
            {static_cast<double>(pose->x), static_cast<double>(pose->y),
             normalize_angle(static_cast<double>(pose->theta))}};
  }
  if (const auto pose = decode_message<bot_core::pose_t>(bytes)) {
    const double(&q)[4] = pose->orientation;
    return {stamp_of(pose->utime),
            {pose->pos[0], pose->pos[1], yaw_of_quaternion(q[0], q[1], q[2], q[3])}};
  }
  if (const auto odometry = decode_message<ros_odometry_t>(bytes)) {
    return flat(odometry->header, odometry->pose.pose);
  }
  const auto pose = decode_message<ros_pose_stamped_t>(bytes);
  require(pose.has_value(), kUndecodable);
  return flat(pose->header, pose->pose);
}

LaserScan scan_of(const ros_laser_scan_t& message) {
  LaserScan scan;
  scan.utime = stamp_of(utime_us_of(message.header));
  scan.channel = channels::kLidar;
  scan.ranges_m = message.ranges;
  scan.first_bearing_rad = static_cast<double>(message.angle_min);
  scan.bearing_step_rad = static_cast<double>(message.angle_increment);
  require(std::isfinite(scan.first_bearing_rad) && std::isfinite(scan.bearing_step_rad),
          "scan with angles that are not finite");
  return scan;
}

void mirror(LaserScan& scan) {
  scan.first_bearing_rad = -scan.first_bearing_rad;
  scan.bearing_step_rad = -scan.bearing_step_rad;
  for (float& bearing : scan.bearings_rad) bearing = -bearing;
}

// From the first beam on, whatever turn each bearing is given in.
std::vector<double> turned_rad(const LaserScan& scan) {
  std::vector<double> turned(scan.size(), 0.0);
  for (std::size_t beam = 1; beam < scan.size(); ++beam) {
    turned[beam] =
        turned[beam - 1] + normalize_angle(scan.bearing_rad(beam) - scan.bearing_rad(beam - 1));
  }
  return turned;
}

// See settle_direction().
void settle_by_stamp(LaserScan& scan) {
  const std::size_t beams = scan.size();
  if (beams < 2 || scan.time_offsets_s.size() != beams) return;
  const auto [first, last] =
      std::minmax_element(scan.time_offsets_s.begin(), scan.time_offsets_s.end());
  const double first_s = static_cast<double>(*first), last_s = static_cast<double>(*last);
  const std::vector<double> turned = turned_rad(scan);
  const double later_s = static_cast<double>(scan.time_offsets_s.back()) -
                         static_cast<double>(scan.time_offsets_s.front());
  const bool rises = turned.back() * (later_s >= 0.0 ? 1.0 : -1.0) > 0.0;
  const bool is_stamped_last = -first_s > std::abs(last_s);
  if (rises && !is_stamped_last) mirror(scan);
  // The next turn begins where the array does, one beam after its end. With a stride the times
  // stop short of the stamp.
  const double turn_s = std::max(-first_s, last_s - first_s);
  const double round = turned.back() * static_cast<double>(beams) / static_cast<double>(beams - 1);
  for (std::size_t beam = 0; beam < beams; ++beam) {
    float& time_s = scan.time_offsets_s[beam];
    time_s = rises && is_stamped_last
                 ? static_cast<float>(turn_s * (turned.back() - turned[beam]) / round)
                 : static_cast<float>(static_cast<double>(time_s) - first_s);
  }
  scan.utime = scan.utime + Duration::from_seconds(first_s);
}

uint64_t big_endian(std::span<const uint8_t> message, std::size_t at, std::size_t bytes) {
  uint64_t value = 0;
  for (std::size_t i = at; i < at + bytes; ++i) value = (value << 8U) | message[i];
  return value;
}

}  // namespace

OdometrySample TickOdometry::add(const maebot_encoders_t& ticks, const ForeignChannel& base) {
  if (last_) {
    const auto metres = [&base](auto from, auto to) {
      return (static_cast<double>(to) - static_cast<double>(from)) * base.metres_per_tick;
    };
    const double left_m = metres(last_->left_ticks_total, ticks.left_ticks_total);
    const double right_m = metres(last_->right_ticks_total, ticks.right_ticks_total);
    pose_ = pose_ * rolled(left_m, right_m, base.track_m);
  }
  last_ = ticks;
  OdometrySample sample;
  sample.utime = stamp_of(ticks.utime);
  sample.odom_from_robot = pose_;
  sample.left_clicks = ticks.left_ticks_total;
  sample.right_clicks = ticks.right_ticks_total;
  return sample;
}

void settle_direction(LaserScan& scan, const ForeignChannel& entry) {
  if (entry.direction_by_stamp) settle_by_stamp(scan);
  if (entry.clockwise) mirror(scan);
}

LaserScan ForeignMessages::decode_scan(std::span<const uint8_t> bytes,
                                       const ForeignChannel& entry) {
  told_min_m_.reset();
  told_max_m_.reset();
  LaserScan scan;
  if (const auto raw = decode_message<lidar_raw_t>(bytes)) {
    scan = from_message(*raw, channels::kLidarRaw);
  } else if (const auto message = decode_message<ros_laser_scan_t>(bytes)) {
    scan = scan_of(*message);
    const double min_m = static_cast<double>(message->range_min);
    const double max_m = static_cast<double>(message->range_max);
    if (min_m >= 0.0 && max_m > min_m && std::isfinite(max_m)) {
      told_min_m_ = min_m;
      told_max_m_ = max_m;
    }
  } else {
    const auto planar = decode_message<bot_core::planar_lidar_t>(bytes);
    require(planar.has_value(), kUndecodable);
    scan = from_message(*planar, channels::kLidar);
  }
  settle_direction(scan, entry);
  require(scan.size() >= 2, "scan of fewer than 2 beams");
  return scan;
}

Sample ForeignMessages::decode(std::span<const uint8_t> bytes, const ForeignChannel& entry) {
  if (entry.meaning == "lidar") return decode_scan(bytes, entry);
  if (entry.meaning == "encoders") {
    const auto ticks = decode_message<maebot_encoders_t>(bytes);
    require(ticks.has_value(), kUndecodable);
    return ticks_.add(*ticks, entry);
  }
  const StampedPose stamped = pose_in(bytes);
  require(is_finite(stamped.pose), "pose that is not finite");
  if (entry.meaning == "true_pose") return TruePose{stamped.utime, stamped.pose};
  OdometrySample sample;
  sample.utime = stamped.utime;
  sample.odom_from_robot = stamped.pose;
  return sample;
}

SensorInfo ForeignMessages::info_of(const LaserScan& scan, const ForeignChannel& entry) const {
  SensorInfo info;
  info.utime = scan.utime;
  info.channel = scan.channel;
  info.range_min_m = told_min_m_.value_or(entry.range_min_m);
  info.range_max_m = told_max_m_.value_or(entry.range_max_m);
  return info;
}

const ForeignChannel* entry_of(const ForeignTable& table,
                               const std::string& channel,
                               const std::string& fingerprint) {
  for (const ForeignChannel& entry : table.channels) {
    if (entry.fingerprint == fingerprint && ChannelPattern(entry.channel).matches(channel)) {
      return &entry;
    }
  }
  return nullptr;
}

std::string fingerprint_in(std::span<const uint8_t> message) {
  if (message.size() < 8) return "";
  return fingerprint_text(static_cast<int64_t>(big_endian(message, 0, 8)));
}

std::string fingerprint_text(int64_t hash) {
  return format("%016llx", static_cast<unsigned long long>(hash));
}

std::optional<int64_t> utime_in(std::span<const uint8_t> message) {
  const auto number = [message](std::size_t at, std::size_t bytes) {
    return big_endian(message, at, bytes);
  };
  if (message.size() < 16) return std::nullopt;
  // Counts and a header's number come before its seconds and nanoseconds.
  const uint64_t type = number(0, 8);
  std::size_t seconds_at = 0;
  if (type == static_cast<uint64_t>(ros_laser_scan_t::getHash())) seconds_at = 20;
  if (type == static_cast<uint64_t>(ros_odometry_t::getHash()) ||
      type == static_cast<uint64_t>(ros_pose_stamped_t::getHash())) {
    seconds_at = 12;
  }
  if (seconds_at == 0) return static_cast<int64_t>(number(8, 8));
  if (message.size() < seconds_at + 8) return std::nullopt;
  const auto seconds = static_cast<int32_t>(number(seconds_at, 4));
  return int64_t{seconds} * 1'000'000 + static_cast<int64_t>(number(seconds_at + 4, 4)) / 1000;
}

}  // namespace marco
