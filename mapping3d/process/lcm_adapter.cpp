#include "mapping3d/process/lcm_adapter.hpp"

#include <algorithm>
#include <cmath>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/stamp.hpp"
#include "mapping3d/process/model_messages.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_pose_t.hpp"

namespace marco::mapping3d {
namespace {

// By which a scan may come later than the newest pose, and still find its own.
constexpr double kLateS = 10.0;

}  // namespace

Mapping3dAdapter::Mapping3dAdapter(process::Bus& bus,
                                   const Mapping3dAdapterOptions& options,
                                   std::function<void(const std::string&)> warn)
    : bus_(bus),
      options_(options),
      drops_(std::move(warn)),
      mapper_(options.mapper),
      pantilt_(Duration::from_seconds(options.pantilt_gap_s),
               Duration::from_seconds(options.pantilt_reach_s)) {
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
    require(note_sensor(sensors_, info), kTooManySensors);
  });
  bus_.subscribe<pantilt_state_t>(channels::kPanTiltState, drops_,
                                  [this](const auto& message, auto&) {
                                    if (!pantilt_.add(from_message(message))) {
                                      drops_.count("pan-tilt stamp that steps back");
                                    }
                                    use_waiting();
                                  });
  bus_.subscribe<slam_pose_t>(channels::kSlamPose, drops_, [this](const auto& pose, auto&) {
    const Pose2 world_from_robot{pose.x_m, pose.y_m, normalize_angle(pose.theta_rad)};
    require(is_finite(world_from_robot), "slam_pose_t: pose is not finite");
    // A pose in no map: what is seen from there would be laid over what is.
    require(pose.status != slam_pose_t::STATUS_LOST, "slam_pose_t: SLAM does not know its place");
    poses_[stamp_of(pose.utime)] = world_from_robot;
    use_waiting();
  });
  bus_.subscribe<trajectory_t>(channels::kTrajectory, drops_, [this](const auto& message, auto&) {
    follow(from_message(message));
  });
  bus_.subscribe<map_request_t>(channels::kMapRequest, drops_, [this](const auto& request, auto&) {
    if (request.channel.empty() || request.channel == channels::kMesh) {
      mapper_.refine();
      publish_model(newest_);
    }
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
  // The next pose tells how far the robot drove during the scan.
  return poses_.contains(scan.utime) && poses_.rbegin()->first >= last_beam &&
         pantilt_.reaches(last_beam);
}

/// Between the poses of two scans; beyond the newest as if the robot drove on. Asked for a moment
/// at or after a scan that has a pose.
Pose2 Mapping3dAdapter::pose_at(Utime utime) const {
  auto after = poses_.lower_bound(utime);
  if (after == poses_.end() && poses_.size() > 1) after = std::prev(after);
  if (after == poses_.end()) return poses_.rbegin()->second;
  if (after->first == utime || after == poses_.begin()) return after->second;
  const auto before = std::prev(after);
  const double part = (utime - before->first).seconds() / (after->first - before->first).seconds();
  return interpolate(before->second, after->second, std::min(part, 2.0));
}

void Mapping3dAdapter::follow(const Trajectory& keys) {
  mapper_.follow(keys, poses_);
  // From now on poses come in the new frame, so those of scans still waiting must be in it too.
  std::map<Utime, Pose2> corrections;
  for (const StampedPose2& key : keys) {
    const auto known = poses_.find(key.utime);
    if (known != poses_.end()) {
      corrections[key.utime] = key.world_from_robot * known->second.inverse();
    }
  }
  for (auto& [utime, world_from_robot] : poses_) {
    const auto after = corrections.upper_bound(utime);
    if (after != corrections.begin())
      world_from_robot = std::prev(after)->second * world_from_robot;
  }
  forget_poses_between(corrections);
}

void Mapping3dAdapter::forget_poses_between(const std::map<Utime, Pose2>& keys) {
  if (poses_.empty()) return;
  Utime needed = poses_.rbegin()->first - Duration::from_seconds(kLateS);
  if (!waiting_.empty()) needed = std::min(needed, waiting_.front().utime);
  // pose_at() looks at the pose before, too.
  const auto first_needed = poses_.lower_bound(needed);
  const auto kept = first_needed == poses_.begin() ? first_needed : std::prev(first_needed);
  for (auto pose = poses_.begin(); pose != kept;) {
    pose = keys.contains(pose->first) ? std::next(pose) : poses_.erase(pose);
  }
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
  const Utime last_beam = scan.utime + Duration::from_seconds(info.scan_duration_s);
  const auto first = pantilt_.at(scan.utime), last = pantilt_.at(last_beam);
  if (pose == poses_.end() || base == sensors_.end() || !first || !last) {
    drops_.count(pose == poses_.end() ? "scan without SLAM_POSE" : "scan without pan-tilt angles");
    return;
  }
  const auto robot_from_sensor = [&](const PanTiltAngles& angles) {
    return robot_from_pantilt_sensor(options_.correction.base(base->second),
                                     options_.correction.sensor(info), angles.pan_rad,
                                     angles.tilt_rad);
  };
  SceneRow row;
  row.utime = scan.utime;
  row.first_bearing_rad = scan.first_bearing_rad;
  row.bearing_step_rad = scan.bearing_step_rad;
  row.robot_from_sensor_first = robot_from_sensor(*first);
  row.robot_from_sensor_last = robot_from_sensor(*last);
  row.world_from_robot = pose->second;
  row.first_robot_from_last_robot = marco::between(pose->second, pose_at(last_beam));
  row.pan_first_rad = first->pan_rad;
  row.pan_last_rad = last->pan_rad;
  row.tilt_first_rad = first->tilt_rad;
  row.tilt_last_rad = last->tilt_rad;
  row.ranges_m.reserve(scan.size());
  for (const float range_m : scan.ranges_m) {
    const auto range = static_cast<double>(range_m);
    row.ranges_m.push_back(range >= info.range_min_m && range < info.range_max_m ? range_m : 0.0F);
  }
  const double pan_rad = first->pan_rad + 0.5 * normalize_angle(last->pan_rad - first->pan_rad);
  const double tilt_rad = 0.5 * (first->tilt_rad + last->tilt_rad);
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
  mapper_.refine();
  if (!mapper_.scenes().empty()) publish_model(newest_);
}

std::optional<CalibrationResult> Mapping3dAdapter::calibrate(
    const CalibrationOptions& options) const {
  const auto base = sensors_.find(channels::kPanTiltState);
  for (const auto& [channel, info] : sensors_) {
    if (info.mount != SensorInfo::Mount::pantilt || mapper_.scenes().empty()) continue;
    if (base != sensors_.end()) {
      return marco::mapping3d::calibrate(mapper_.scenes(), {base->second, info}, options);
    }
  }
  return std::nullopt;
}

}  // namespace marco::mapping3d
