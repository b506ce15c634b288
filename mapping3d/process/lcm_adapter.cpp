#include "mapping3d/process/lcm_adapter.hpp"

#include <cmath>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/stamp.hpp"
#include "mapping3d/process/model_messages.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_pose_t.hpp"

namespace marco::mapping3d {

Mapping3dAdapter::Mapping3dAdapter(process::Bus& bus,
                                   const Mapping3dAdapterOptions& options,
                                   std::function<void(const std::string&)> warn)
    : bus_(bus), options_(options), drops_(std::move(warn)), mapper_(options.mapper) {
  validate(options, "mapping3d_process");
  subscribe();
}

void Mapping3dAdapter::subscribe() {
  bus_.subscribe_raw(channels::kLidarPattern, [this](const process::RawMessage& raw) {
    drops_.count_received();
    try {
      const auto sample = decode_sample(std::string(raw.channel), raw.bytes);
      if (sample) {
        on_scan(std::get<LaserScan>(*sample));
      } else {
        drops_.count("undecodable");
      }
    } catch (const std::invalid_argument& bad_message) {
      drops_.count(bad_message.what());
    }
  });
  bus_.subscribe<sensor_info_t>(channels::kSensorInfo, drops_, [this](const auto& message, auto&) {
    const SensorInfo info = from_message(message);
    sensors_[info.channel] = info;
  });
  bus_.subscribe<pantilt_state_t>(channels::kPanTiltState, drops_,
                                  [this](const auto& message, auto&) {
                                    const PanTiltState state = from_message(message);
                                    pantilt_.add(state.utime, {state.pan_rad, state.tilt_rad, 0.0});
                                    use_waiting();
                                  });
  bus_.subscribe<slam_pose_t>(channels::kSlamPose, drops_, [this](const auto& pose, auto&) {
    const Pose2 world_from_robot{pose.x_m, pose.y_m, normalize_angle(pose.theta_rad)};
    require(is_finite(world_from_robot), "slam_pose_t: pose is not finite");
    poses_[stamp_of(pose.utime)] = world_from_robot;
    use_waiting();
  });
  bus_.subscribe<trajectory_t>(channels::kTrajectory, drops_, [this](const auto& message, auto&) {
    mapper_.follow(from_message(message), poses_);
  });
  bus_.subscribe<map_request_t>(channels::kMapRequest, drops_, [this](const auto& request, auto&) {
    if (request.channel.empty() || request.channel == channels::kMesh) publish_model(newest_);
  });
}

void Mapping3dAdapter::on_scan(LaserScan scan) {
  const auto info = sensors_.find(scan.channel);
  if (info == sensors_.end() || info->second.mount != SensorInfo::Mount::pantilt) return;
  if (!scan.bearings_rad.empty()) {
    drops_.count("scan with bearings of its own: no row of a scene");
    return;
  }
  newest_ = scan.utime;
  waiting_.push_back(std::move(scan));
  use_waiting();
}

bool Mapping3dAdapter::ready(const LaserScan& scan) const {
  if (std::abs((newest_ - scan.utime).seconds()) > options_.patience_s) return true;
  const Utime last_beam =
      scan.utime + Duration::from_seconds(sensors_.at(scan.channel).scan_duration_s);
  return poses_.contains(scan.utime) && !pantilt_.empty() && pantilt_.newest() >= last_beam;
}

void Mapping3dAdapter::use_waiting() {
  while (!waiting_.empty() && ready(waiting_.front())) {
    const LaserScan scan = std::move(waiting_.front());
    waiting_.pop_front();
    use(scan);
  }
}

void Mapping3dAdapter::use(const LaserScan& scan) {
  const SensorInfo& info = sensors_.at(scan.channel);
  const auto base = sensors_.find(channels::kPanTiltState);
  const auto pose = poses_.find(scan.utime);
  const Duration duration = Duration::from_seconds(info.scan_duration_s);
  const Duration reach = Duration::from_seconds(0.1);
  const auto first = pantilt_.at(scan.utime, reach);
  const auto last = pantilt_.at(scan.utime + duration, reach);
  if (pose == poses_.end() || base == sensors_.end() || !first || !last) {
    drops_.count(pose == poses_.end() ? "scan without SLAM_POSE" : "scan without pan-tilt angles");
    return;
  }
  SceneRow row;
  row.utime = scan.utime;
  row.first_bearing_rad = scan.first_bearing_rad;
  row.bearing_step_rad = scan.bearing_step_rad;
  row.robot_from_sensor_first =
      robot_from_pantilt_sensor(base->second, info, first->x_m, first->y_m);
  row.robot_from_sensor_last = robot_from_pantilt_sensor(base->second, info, last->x_m, last->y_m);
  row.world_from_robot = pose->second;
  row.ranges_m.reserve(scan.size());
  for (const float range_m : scan.ranges_m) {
    const auto range = static_cast<double>(range_m);
    row.ranges_m.push_back(range >= info.range_min_m && range < info.range_max_m ? range_m : 0.0F);
  }
  const double pan_rad = 0.5 * (first->x_m + last->x_m), tilt_rad = 0.5 * (first->y_m + last->y_m);
  if (mapper_.add(row, pan_rad, tilt_rad)) publish_scene(mapper_.scenes().back());
}

void Mapping3dAdapter::publish_scene(const Scene& scene) {
  for (const scene_t& message : scene_messages(scene)) bus_.publish(channels::kScene, message);
}

void Mapping3dAdapter::publish_model(Utime utime) {
  for_each_tile(mapper_.model(), utime, ++revision_,
                [this](const mesh_t& tile) { bus_.publish(channels::kMesh, tile); });
}

void Mapping3dAdapter::finish() {
  while (!waiting_.empty()) {
    const LaserScan scan = std::move(waiting_.front());
    waiting_.pop_front();
    use(scan);
  }
  if (mapper_.finish()) publish_scene(mapper_.scenes().back());
  if (!mapper_.scenes().empty()) publish_model(newest_);
}

}  // namespace marco::mapping3d
