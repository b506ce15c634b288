#include "simulator/live/live_cameras.hpp"

#include "simulator/camera_view.hpp"

namespace marco::sim {

LiveCameras::LiveCameras(const RayCaster& rays, const RobotSpec& spec)
    : rays_(rays), specs_(spec.cameras), next_(spec.cameras.size()) {
  validate(spec, "robot");
  base_.parent_from_sensor = make_pose3(three(spec.pantilt.position_m, "pantilt.position_m"));
  base_.tilt_axis_m = three(spec.pantilt.tilt_axis_m, "pantilt.tilt_axis_m");
  for (const LiveCameraSpec& camera : specs_) {
    require(camera.mount == "robot" || camera.mount == "pantilt",
            "cameras.mount '" + camera.mount + "': expected robot or pantilt");
    const Eigen::Vector3d turn = three(camera.roll_pitch_yaw_deg, "cameras.roll_pitch_yaw_deg");
    SensorInfo info;
    info.channel = camera.channel;
    info.mount = camera.mount == "robot" ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
    info.parent_from_sensor =
        make_pose3(three(camera.position_m, "cameras.position_m"), deg_to_rad(turn.x()),
                   deg_to_rad(turn.y()), deg_to_rad(turn.z()));
    info.focal_length_px = camera.view.focal_length_px();
    infos_.push_back(info);
  }
}

std::optional<Pose3> LiveCameras::robot_from_camera(std::size_t camera) const {
  const SensorInfo& info = infos_[camera];
  return robot_from_sensor(info, &base_, pantilt_);
}

std::vector<LiveCameras::Shot> LiveCameras::on_pose(const TruePose& pose) {
  std::vector<Shot> shots;
  for (std::size_t i = 0; i < specs_.size(); ++i) {
    if (pose.utime < next_[i]) continue;
    const auto place = robot_from_camera(i);
    if (!place) continue;
    const Duration period = Duration::from_seconds(1.0 / specs_[i].rate_hz);
    next_[i] = std::max(next_[i] + period, pose.utime + period - Duration::from_us(1));
    shots.push_back(
        {i, pose.utime, picture_of(rays_, lift(pose.world_from_robot) * *place, specs_[i].view)});
  }
  return shots;
}

}  // namespace marco::sim
