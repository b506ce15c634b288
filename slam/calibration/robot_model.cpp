#include "slam/calibration/robot_model.hpp"

#include "common/covariance.hpp"
#include "common/input/sensor_calibration.hpp"

namespace marco::slam {

Pose2 axle_motion(const std::vector<WheelStep>& wheels, const RobotModel& model) {
  Pose2 start_from_now;
  for (const WheelStep& step : wheels) {
    const double left_m = model.left_scale * step.left, right_m = model.right_scale * step.right;
    const ArcMotion arc{0.5 * (left_m + right_m),
                        0.5 * (model.left_scale + model.right_scale) * step.aside,
                        (right_m - left_m) / model.track_m};
    start_from_now = start_from_now * arc.moved();
  }
  return start_from_now;
}

Eigen::Vector3d error_of(const MotionSample& sample, const RobotModel& model) {
  const Pose2 laser = sample.robot_from_axle.inverse() * model.robot_from_laser;
  const Pose2 expected = laser.inverse() * axle_motion(sample.wheels, model) * laser;
  return difference(sample.laser_moved, expected);
}

}  // namespace marco::slam
