#include "mapping3d/process/mapping3d_adapter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/covariance.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "live/sensor_feed.hpp"
#include "mapping3d/process/model_messages.hpp"
#include "marco/map_request_t.hpp"

namespace marco::mapping3d {
namespace {

// How much later than the newest pose a scan may come and still find its own.
constexpr double kLateS = 10.0;

struct Bearings {
  double first_rad, step_rad;
};

// Nothing where a row of a scene cannot hold the scan.
std::optional<Bearings> regular_bearings(const LaserScan& scan) {
  if (scan.bearings_rad.empty()) return Bearings{scan.first_bearing_rad, scan.bearing_step_rad};
  constexpr double kOfAStep = 0.1;  // no beam falls to its neighbour
  if (scan.size() < 2 || scan.bearings_rad.size() != scan.size()) return std::nullopt;
  const double first_rad = scan.bearing_rad(0);
  const double step_rad =
      (scan.bearing_rad(scan.size() - 1) - first_rad) / static_cast<double>(scan.size() - 1);
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    const double off_rad =
        scan.bearing_rad(beam) - first_rad - static_cast<double>(beam) * step_rad;
    if (!(std::abs(off_rad) <= kOfAStep * std::abs(step_rad))) return std::nullopt;
  }
  return Bearings{first_rad, step_rad};
}

// Whether a row needs no times of its beams: they are measured one after another in equal steps.
bool are_even(const std::vector<float>& offsets_s, double duration_s) {
  constexpr double kStampS = 2e-6;  // messages round times to microseconds
  const double step_s = duration_s / std::max(1.0, static_cast<double>(offsets_s.size()) - 1.0);
  for (std::size_t beam = 0; beam < offsets_s.size(); ++beam) {
    const double even_s = static_cast<double>(beam) * step_s;
    if (std::abs(static_cast<double>(offsets_s[beam]) - even_s) > kStampS) return false;
  }
  return true;
}

}  // namespace

Mapping3dAdapter::Mapping3dAdapter(process::Bus& bus,
                                   const Mapping3dAdapterOptions& options,
                                   std::function<void(const std::string&)> warn)
    : bus_(bus),
      options_(options),
      drops_(std::move(warn)),
      mapper_(options.mapper),
      input_(
          options.input, lcm_channel_names(), [this](const auto& cause) { drops_.count(cause); }) {
  validate(options, "mapping3d_process");
  subscribe();
}

void Mapping3dAdapter::subscribe() {
  feed(bus_, drops_, input_,
       {[this](const LaserScan& scan) { return is_wanted(scan); },
        [this] { use_complete_scans(); }});
  bus_.subscribe<slam_pose_t>(channels::kSlamPose, drops_, [this](const auto& message, auto&) {
    const PoseEstimate pose = from_message(message);
    // What is seen from a pose in no map would be laid over the map.
    require(pose.status != PoseEstimate::Status::lost, "slam_pose_t: SLAM is lost");
    note_pose(pose);
    use_complete_scans();
  });
  bus_.subscribe<trajectory_t>(channels::kTrajectory, drops_, [this](const auto& message, auto&) {
    follow(from_message(message));
  });
  bus_.subscribe<map_request_t>(channels::kMapRequest, drops_, [this](const auto& request, auto&) {
    if (request.channel.empty() || request.channel == channels::kMesh) {
      refine();
      publish_model(newest_);
    }
  });
}

bool Mapping3dAdapter::is_wanted(const LaserScan& scan) {
  const SensorInfo* info = input_.sensor_of(scan.channel);
  if (info == nullptr) return false;
  if (info->mount == SensorInfo::Mount::robot && !is_steep(info->parent_from_sensor)) return false;
  if (regular_bearings(scan)) return true;
  drops_.count("scan with irregular bearings: not a row of a scene");
  return false;
}

void Mapping3dAdapter::note_pose(const PoseEstimate& pose) {
  if (newest_pose_) {
    const Eigen::Vector3d moved = difference(pose.world_from_robot, newest_pose_->world_from_robot);
    const Eigen::Matrix3d information = information_of(newest_pose_->covariance + pose.covariance);
    if (squared_mahalanobis_distance(moved, information) > kChi2Dof3Quantile999) {
      moved_at_.insert(pose.utime);
    }
  }
  poses_[pose.utime] = pose.world_from_robot;
  newest_pose_ = pose;
}

bool Mapping3dAdapter::moved_between(Utime from, Utime until) const {
  const auto after = moved_at_.upper_bound(from);
  return after != moved_at_.end() && *after <= until;
}

bool Mapping3dAdapter::stands_during(const SynchronizedScan& scan) const {
  if (!scan.odometry_step || !stood_still({}, *scan.odometry_step)) return false;
  const auto next = poses_.lower_bound(scan.scan.utime + Duration::from_seconds(scan.duration_s));
  return next == poses_.end() || !moved_between(scan.scan.utime, next->first);
}

std::optional<Utime> Mapping3dAdapter::stop_of(const SynchronizedScan& scan) {
  const auto& odom_from_robot = scan.motion.odom_from_robot;
  const Utime utime = scan.scan.utime;
  if (!odom_from_robot) {
    stop_.reset();
    return std::nullopt;
  }
  const bool stands = stop_ && stood_still(stop_->odom_from_robot, *odom_from_robot) &&
                      !moved_between(stop_->newest, utime);
  if (!stands) stop_ = {utime, utime, *odom_from_robot};
  stop_->newest = utime;
  return stop_->since;
}

bool Mapping3dAdapter::has_pose(const SynchronizedScan& scan) const {
  const Utime utime = scan.scan.utime;
  if (std::abs((newest_ - utime).seconds()) > options_.input.patience_s) return true;
  // The next pose gives the robot's motion during the scan.
  return poses_.contains(utime) &&
         poses_.rbegin()->first >= utime + Duration::from_seconds(scan.duration_s);
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
  const PathCorrection correction(keys, poses_);
  mapper_.follow(correction);
  // From now on poses come in the new frame, so those of scans still waiting must be in it too.
  for (auto& [utime, world_from_robot] : poses_) {
    world_from_robot = correction.corrected(utime, world_from_robot);
  }
  forget_poses_between(correction);
}

void Mapping3dAdapter::forget_poses_between(const PathCorrection& keys) {
  if (poses_.empty()) return;
  Utime needed = poses_.rbegin()->first - Duration::from_seconds(kLateS);
  if (!waiting_.empty()) needed = std::min(needed, waiting_.front().scan.utime);
  // pose_at() looks at the pose before, too.
  const auto first_needed = poses_.lower_bound(needed);
  const auto kept = first_needed == poses_.begin() ? first_needed : std::prev(first_needed);
  if (kept != poses_.end()) {
    moved_at_.erase(moved_at_.begin(), moved_at_.lower_bound(kept->first));
  }
  for (auto pose = poses_.begin(); pose != kept;) {
    pose = keys.has_key(pose->first) ? std::next(pose) : poses_.erase(pose);
  }
}

void Mapping3dAdapter::use_complete_scans() {
  while (std::optional<SynchronizedScan> scan = input_.next()) {
    newest_ = scan->scan.utime;
    waiting_.push_back(std::move(*scan));
  }
  while (!waiting_.empty() && has_pose(waiting_.front())) {
    use(waiting_.front());
    waiting_.pop_front();
  }
}

void Mapping3dAdapter::use(const SynchronizedScan& synchronized) {
  const LaserScan& scan = synchronized.scan;
  const SensorInfo& info = synchronized.info;
  const PanTiltAngles &first = synchronized.first_angles, &last = synchronized.last_angles;
  const auto pose = poses_.find(scan.utime);
  if (pose == poses_.end()) return drops_.count("scan without SLAM_POSE");
  const bool is_fixed = info.mount == SensorInfo::Mount::robot;
  if (!is_fixed && !synchronized.angles_known) {
    return drops_.count("scan without pan-tilt angles");
  }
  const auto place_at = [&](const PanTiltAngles& angles) {
    if (is_fixed) return info.parent_from_sensor;
    return robot_from_pantilt_sensor(options_.correction.base(*input_.pantilt_base()),
                                     options_.correction.sensor(info), angles.pan_rad,
                                     angles.tilt_rad);
  };
  const Utime last_beam = scan.utime + Duration::from_seconds(synchronized.duration_s);
  SceneRow row;
  row.utime = scan.utime;
  const auto bearings = regular_bearings(scan);
  row.first_bearing_rad = bearings->first_rad;
  row.bearing_step_rad = bearings->step_rad;
  if (!are_even(scan.time_offsets_s, synchronized.duration_s)) {
    row.beam_parts.reserve(scan.size());
    for (const float offset_s : scan.time_offsets_s) {
      row.beam_parts.push_back(offset_s /
                               static_cast<float>(std::max(synchronized.duration_s, 1e-6)));
    }
  }
  row.robot_from_sensor_first = place_at(first);
  row.robot_from_sensor_last = place_at(last);
  row.world_from_robot = pose->second;
  row.stop = stop_of(synchronized);
  if (!stands_during(synchronized)) {
    row.first_robot_from_last_robot = marco::between(pose->second, pose_at(last_beam));
  }
  row.duration_s = synchronized.duration_s;
  row.pan_first_rad = first.pan_rad;
  row.pan_last_rad = last.pan_rad;
  row.tilt_first_rad = first.tilt_rad;
  row.tilt_last_rad = last.tilt_rad;
  row.ranges_m.reserve(scan.size());
  for (const float range_m : scan.ranges_m) {
    const auto range = static_cast<double>(range_m);
    row.ranges_m.push_back(range >= info.range_min_m && range < info.range_max_m ? range_m : 0.0F);
  }
  const double pan_rad = first.pan_rad + 0.5 * normalize_angle(last.pan_rad - first.pan_rad);
  const double tilt_rad = 0.5 * (first.tilt_rad + last.tilt_rad);
  if (mapper_.add(row, pan_rad, tilt_rad, info.channel)) publish_scene(mapper_.scenes().back());
}

void Mapping3dAdapter::refine() {
  if (on_long_work_) {
    on_long_work_(process::kBusy + ("joining " + std::to_string(mapper_.scenes().size())) +
                  " scenes");
  }
  const std::size_t known = mapper_.own_body().size();
  mapper_.refine();
  const std::vector<BodyPart>& body = mapper_.own_body();
  if (body.size() > known) drops_.count(describe(body) + ": these returns are ignored");
}

void Mapping3dAdapter::publish_scene(const Scene& scene) {
  for (const scene_t& message : scene_messages(scene)) bus_.publish(channels::kScene, message);
}

void Mapping3dAdapter::publish_model(Utime utime) {
  for_each_tile(mapper_.model(), utime, ++revision_,
                [this](const mesh_t& tile) { bus_.publish(channels::kMesh, tile); });
}

void Mapping3dAdapter::finish() {
  input_.complete_all();
  use_complete_scans();
  for (const SynchronizedScan& scan : std::exchange(waiting_, {})) use(scan);
  const std::vector<Scene>& scenes = mapper_.scenes();
  const std::size_t ended = mapper_.finish();
  for (std::size_t i = scenes.size() - ended; i < scenes.size(); ++i) publish_scene(scenes[i]);
  refine();
  if (!mapper_.scenes().empty()) publish_model(newest_);
}

std::optional<CalibrationResult> Mapping3dAdapter::calibrate(
    const CalibrationOptions& options) const {
  const SensorInfo* base = input_.pantilt_base();
  if (base == nullptr || mapper_.scenes().empty()) return std::nullopt;
  for (const auto& [channel, info] : input_.sensors()) {
    if (info.mount == SensorInfo::Mount::pantilt) {
      return marco::mapping3d::calibrate(mapper_.scenes(), {*base, info}, options);
    }
  }
  return std::nullopt;
}

}  // namespace marco::mapping3d
