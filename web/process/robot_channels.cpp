#include "web/process/robot_channels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bot_core/image_t.hpp"
#include "common/regular_scan.hpp"
#include "lcm_tools/schema/schema.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/finite_pose.hpp"
#include "lcmtypes/stamp.hpp"
#include "marco/mesh_t.hpp"
#include "web/foxglove/grid.hpp"
#include "web/foxglove/messages.hpp"
#include "web/foxglove/schemas.hpp"
#include "web/page_schemas.hpp"

namespace marco::web {
namespace {

using foxglove::number;

constexpr const char* kOdomFrame = "odom";
constexpr const char* kBaseFrame = "base";
constexpr const char* kLaserFrame = "laser";
constexpr Duration kPointsEvery = Duration::from_us(50'000);
// Odometry is asked for so far beyond its newest sample.
constexpr Duration kReach = Duration::from_us(200'000);
constexpr Duration kOtherLaserAfter = Duration::from_us(1'000'000);

template <class Message>
Message decoded(const process::RawMessage& raw) {
  auto message = decode_message<Message>(raw.bytes);
  if (!message) throw std::invalid_argument("undecodable");
  return std::move(*message);
}

}  // namespace

RobotChannels::RobotChannels(Hub& hub, process::DropCounter& drops) : hub_(hub), drops_(drops) {
  const auto add = [&hub](const char* topic, const char* schema) {
    return hub.add_channel(topic, schema, foxglove::schema_of(schema));
  };
  map_ = add("/map", "foxglove.Grid");
  scan_ = add("/scan", "foxglove.LaserScan");
  pose_ = add("/pose", "foxglove.PoseInFrame");
  path_ = add("/path", "foxglove.PosesInFrame");
  camera_ = add("/camera", "foxglove.CompressedImage");
  frames_ = add("/tf", "foxglove.FrameTransforms");
  walls_ = add("/walls", "foxglove.SceneUpdate");
  loops_ = add("/loops", "foxglove.SceneUpdate");
  model_ = add("/model", "foxglove.SceneUpdate");
  tiles_ = add_page_channel(hub, "page/tiles");
  points_ = add_page_channel(hub, "page/scan");
}

void RobotChannels::take(const process::RawMessage& message) {
  const auto fingerprint = lcm_schema::fingerprint_of(message.bytes);
  if (!fingerprint) return;
  try {
    if (take_known(message, *fingerprint)) drops_.count_received();
  } catch (const std::invalid_argument& bad_message) {
    drops_.count_received();
    drops_.count(bad_message.what());
  }
}

bool RobotChannels::take_known(const process::RawMessage& raw, uint64_t fingerprint) {
  using lcm_schema::is_a;
  const std::string channel(raw.channel);
  if (is_a<bot_core::planar_lidar_t>(fingerprint)) {
    take_scan(from_message(decoded<bot_core::planar_lidar_t>(raw), channel), raw.event_time);
  } else if (is_a<lidar_raw_t>(fingerprint)) {
    take_scan(from_message(decoded<lidar_raw_t>(raw), channel), raw.event_time);
  } else if (is_a<sensor_info_t>(fingerprint)) {
    if (!note_sensor(infos_, from_message(decoded<sensor_info_t>(raw)))) {
      throw std::invalid_argument(kTooManySensors);
    }
  } else if (is_a<slam_pose_t>(fingerprint)) {
    const auto message = decoded<slam_pose_t>(raw);
    const Pose2 pose = finite_pose(message.x_m, message.y_m, message.theta_rad,
                                   "slam_pose_t: the pose is not finite or too far away");
    const bool is_lost = message.status == slam_pose_t::STATUS_LOST;
    frame_.on_slam_pose(stamp_of(message.utime), is_lost ? std::nullopt : std::optional(pose),
                        raw.event_time);
    take_pose(stamp_of(message.utime), pose);
  } else if (is_a<odometry_t>(fingerprint)) {
    take_odometry(from_message(decoded<odometry_t>(raw)));
  } else if (is_a<pantilt_state_t>(fingerprint)) {
    head_ = from_message(decoded<pantilt_state_t>(raw)).angles();
  } else if (is_a<grid_map_t>(fingerprint)) {
    take_maps(grids_.add(channel, decoded<grid_map_t>(raw), raw.event_time));
  } else if (is_a<trajectory_t>(fingerprint)) {
    take_lasting<trajectory_t>(path_, raw, foxglove::poses_in_frame);
  } else if (is_a<line_map_t>(fingerprint)) {
    take_lasting<line_map_t>(walls_, raw, foxglove::walls_scene);
  } else if (is_a<loop_closures_t>(fingerprint)) {
    take_lasting<loop_closures_t>(loops_, raw, foxglove::loops_scene);
  } else if (is_a<mesh_t>(fingerprint)) {
    take_model(raw);
  } else if (is_a<bot_core::image_t>(fingerprint)) {
    take_image(raw);
  } else {
    return false;
  }
  return true;
}

std::optional<Pose3> RobotChannels::base_from_laser(const std::string& channel) const {
  const SensorInfo* info = find_sensor(infos_, channels::lidar_of(channel));
  if (info == nullptr) return std::nullopt;
  return robot_from_sensor(*info, find_sensor(infos_, channels::kPanTiltState), head_);
}

void RobotChannels::take_scan(const LaserScan& scan, Utime heard) {
  // One laser is drawn: the first one, while it sends.
  if (laser_ && laser_->channel != scan.channel && heard - laser_->heard < kOtherLaserAfter &&
      heard >= laser_->heard) {
    return;
  }
  laser_ = {heard, scan.channel};
  const auto place = base_from_laser(scan.channel);
  if (hub_.wanted(points_) && (heard - points_sent_ >= kPointsEvery || heard < points_sent_)) {
    points_sent_ = heard;
    publish_points(scan, place.value_or(Pose3::Identity()));
  }
  if (hub_.wanted(scan_)) {
    const auto regular = make_regular(scan, std::numeric_limits<float>::infinity());
    hub_.publish(scan_, ns_of(heard), foxglove::laser_scan(regular, kLaserFrame));
  }
}

Pose2 RobotChannels::drawn_pose(Utime at) const {
  const PoseBuffer& odometry = frame_.odometry();
  const Pose2 odom_now = odometry.empty() ? Pose2{} : odometry.newest_pose();
  if (!map_from_base_) return odom_now;
  // SLAM's pose is of an earlier scan: odometry knows how the robot moved since.
  const auto map_from_odom_now = map_from_odom();
  const auto odom_then = odometry.at(at, kReach);
  return map_from_odom_now && odom_then ? *map_from_odom_now * *odom_then : *map_from_base_;
}

void RobotChannels::publish_points(const LaserScan& scan, const Pose3& base_from_laser) {
  const auto info = infos_.find(scan.channel);
  const double nearest_m = info == infos_.end() ? 0.02 : info->second.range_min_m;
  const double farthest_m = info == infos_.end() ? kFarthestReturnM : info->second.range_max_m;
  const Pose3 map_from_laser = lift(drawn_pose(scan.utime)) * base_from_laser;
  std::string x = R"(,"x_m":[)", y = R"("y_m":[)";
  bool is_first = true;
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    const auto range_m = static_cast<double>(scan.ranges_m[beam]);
    if (!(range_m > nearest_m && range_m < farthest_m)) continue;
    const double bearing = scan.bearing_rad(beam);
    const Eigen::Vector3d point =
        map_from_laser *
        Eigen::Vector3d(range_m * std::cos(bearing), range_m * std::sin(bearing), 0.0);
    if (!std::exchange(is_first, false)) {
      x += ',';
      y += ',';
    }
    x += number(std::round(1e3 * point.x()) / 1e3);
    y += number(std::round(1e3 * point.y()) / 1e3);
  }
  hub_.publish(points_, ns_of(points_sent_),
               R"({"utime":)" + std::to_string(scan.utime.us) + x + "]," + y + "]}");
}

void RobotChannels::take_pose(Utime utime, const Pose2& map_from_base) {
  map_from_base_ = map_from_base;
  posed_ = utime;
  publish_lasting(pose_, utime, {utime.us, [us = utime.us, pose = lift(map_from_base)] {
                                   return foxglove::pose_in_frame(us, kMapFrame, pose);
                                 }});
  publish_frames(utime);
}

void RobotChannels::take_odometry(const OdometrySample& sample) {
  frame_.on_odometry(sample);
  if (!hub_.wanted(frames_)) return;
  hub_.publish(frames_, ns_of(sample.utime),
               foxglove::frame_transforms(sample.utime.us,
                                          {{kOdomFrame, kBaseFrame, lift(sample.odom_from_robot)}}),
               1);
}

std::optional<Pose2> RobotChannels::map_from_odom() const {
  const PoseBuffer& odometry = frame_.odometry();
  if (!map_from_base_ || odometry.empty()) return std::nullopt;
  // Of another clock the newest is the best there is.
  const Pose2 odom_from_base = odometry.at(posed_, kReach).value_or(odometry.newest_pose());
  return *map_from_base_ * odom_from_base.inverse();
}

void RobotChannels::publish_frames(Utime utime) {
  if (!hub_.wanted(frames_)) return;
  std::vector<foxglove::Transform> transforms;
  if (const auto odom = map_from_odom()) {
    transforms.push_back({kMapFrame, kOdomFrame, lift(*odom)});
  } else {
    transforms.push_back({kMapFrame, kBaseFrame, lift(*map_from_base_)});
  }
  if (laser_) {
    const auto laser = base_from_laser(laser_->channel);
    transforms.push_back({kBaseFrame, kLaserFrame, laser.value_or(Pose3::Identity())});
  }
  hub_.publish(frames_, ns_of(utime), foxglove::frame_transforms(utime.us, transforms), 2);
}

void RobotChannels::publish_lasting(uint32_t channel, Utime heard, Lasting message) {
  if (hub_.wanted(channel)) hub_.publish(channel, ns_of(heard), message.json());
  lasting_[channel] = std::move(message);
}

template <class Message, class Json>
void RobotChannels::take_lasting(uint32_t channel, const process::RawMessage& raw, Json json) {
  const auto message = decoded<Message>(raw);
  publish_lasting(channel, raw.event_time,
                  {message.utime, [us = message.utime, value = from_message(message), json] {
                     return json(us, kMapFrame, value);
                   }});
}

void RobotChannels::take_image(const process::RawMessage& raw) {
  if (!hub_.wanted(camera_)) return;
  const auto image = decoded<bot_core::image_t>(raw);
  if (image.pixelformat != bot_core::image_t::PIXEL_FORMAT_MJPEG) return;
  hub_.publish(camera_, ns_of(raw.event_time),
               foxglove::compressed_image(image.utime, "camera", image.data));
}

uint64_t RobotChannels::send_part(Hub::ClientId client, uint32_t channel, uint64_t from) {
  if (channel == tiles_ && !tiled_.empty()) {
    // Whole, so that a page is not drawn piece by piece; later changes come a tile at a time.
    hub_.publish_to(client, tiles_, ns_of(grid_->event_time), tiled_.json(tiled_.places(), true));
  } else if (channel == map_ && grid_) {
    hub_.publish_to(client, map_, ns_of(grid_->event_time), map_json());
  } else if (const auto lasting = lasting_.find(channel); lasting != lasting_.end()) {
    hub_.publish_to(client, channel, lasting->second.utime_us * 1000, lasting->second.json());
  } else if (channel == model_) {
    auto next = model_tiles_.lower_bound(static_cast<uint32_t>(from));
    if (next == model_tiles_.end()) return 0;
    hub_.publish_to(client, model_, next->second.utime_us * 1000, next->second.json, next->first);
    return ++next == model_tiles_.end() ? 0 : next->first;
  }
  return 0;
}

}  // namespace marco::web
