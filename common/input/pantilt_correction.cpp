#include "common/input/pantilt_correction.hpp"

namespace marco {

SensorInfo PanTiltCorrection::base(SensorInfo as_said) const {
  as_said.tilt_axis_m += Eigen::Vector3d(axis_x_m, axis_y_m, 0.0);
  return as_said;
}

SensorInfo PanTiltCorrection::sensor(SensorInfo as_said) const {
  const Pose3 turn = make_pose3(Eigen::Vector3d::Zero(), deg_to_rad(roll_deg),
                                deg_to_rad(pitch_deg), deg_to_rad(yaw_deg));
  as_said.parent_from_sensor.linear() = turn.linear() * as_said.parent_from_sensor.linear();
  as_said.parent_from_sensor.translation() += Eigen::Vector3d(lever_x_m, 0.0, lever_z_m);
  return as_said;
}

}  // namespace marco
