#include "mapping3d/sweep_axis.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::mapping3d {

SweepAxis sweep_axis(const Scene& scene, std::size_t row) {
  constexpr std::size_t kReach = 6;       // rows before and after: a turn above the angles' noise
  constexpr double kLeastTurnRad = 1e-3;  // of less the axis is not known
  const std::size_t before = row - std::min(row, kReach);
  const std::size_t after = std::min(row + kReach, scene.rows.size() - 1);
  const Pose3 moved = scene.rows[after].robot_from_sensor_first *
                      scene.rows[before].robot_from_sensor_first.inverse(Eigen::Isometry);
  const Eigen::AngleAxisd turn(moved.linear());
  SweepAxis axis;
  if (std::abs(turn.angle()) < kLeastTurnRad) return axis;
  axis.direction = turn.axis() * (turn.angle() < 0.0 ? -1.0 : 1.0);
  // The fixed point of the turn nearest to the origin: (I - R) p = t across the axis, regularized
  // along it.
  const Eigen::Matrix3d along = axis.direction * axis.direction.transpose();
  const Eigen::Vector3d across = moved.translation() - along * moved.translation();
  axis.point_m = (Eigen::Matrix3d::Identity() - moved.linear() + along).inverse() * across;
  return axis;
}

double rms_rad(const std::vector<RowTurns>& turns_rad) {
  double squares = 0.0, count = 0.0;
  for (const RowTurns& turns : turns_rad) {
    for (const double turn_rad : turns) squares += turn_rad * turn_rad;
    count += static_cast<double>(turns.size());
  }
  return count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

Scene straightened(const Scene& scene, const RowTurns& turns_rad, double range_m) {
  require(turns_rad.size() == scene.rows.size(), "straightened: expected one turn a row");
  Scene corrected = scene;
  for (std::size_t row = 0; row < scene.rows.size(); ++row) {
    SceneRow& to = corrected.rows[row];
    const SweepAxis axis = sweep_axis(scene, row);
    if (turns_rad[row] != 0.0 && axis.direction != Eigen::Vector3d::Zero()) {
      const Pose3 turn = turn_about(axis.point_m, turns_rad[row] * axis.direction);
      to.robot_from_sensor_first = turn * to.robot_from_sensor_first;
      to.robot_from_sensor_last = turn * to.robot_from_sensor_last;
    }
    for (float& range : to.ranges_m) {
      if (range > 0.0F) range = std::max(0.0F, range + static_cast<float>(range_m));
    }
  }
  return corrected;
}

}  // namespace marco::mapping3d
