#include "slam/line_slam/ekf/wall_observation.hpp"

#include <cmath>

namespace marco::slam {
namespace {

Eigen::Matrix2d rotation_of(double theta_rad) {
  const double c = std::cos(theta_rad), s = std::sin(theta_rad);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

Eigen::Vector2d along_of(const Eigen::Vector4d& ends) {
  return Eigen::Vector2d(ends.tail<2>() - ends.head<2>()).normalized();
}

}  // namespace

Eigen::Vector4d seen_from_robot(const Eigen::Vector3d& robot, const Eigen::Vector4d& wall) {
  const Eigen::Matrix2d to_robot = rotation_of(-robot.z());
  Eigen::Vector4d seen;
  seen.head<2>() = to_robot * (wall.head<2>() - robot.head<2>());
  seen.tail<2>() = to_robot * (wall.tail<2>() - robot.head<2>());
  return seen;
}

void seen_from_robot_jacobians(const Eigen::Vector3d& robot,
                               const Eigen::Vector4d& wall,
                               Eigen::Matrix<double, 4, 3>& by_robot,
                               Eigen::Matrix4d& by_wall) {
  const Eigen::Matrix2d to_robot = rotation_of(-robot.z());
  const double c = std::cos(robot.z()), s = std::sin(robot.z());
  const Eigen::Matrix2d turned = (Eigen::Matrix2d() << -s, c, -c, -s).finished();
  by_wall.setZero();
  for (Eigen::Index i = 0; i < 4; i += 2) {
    by_robot.block<2, 2>(i, 0) = -to_robot;
    by_robot.block<2, 1>(i, 2) = turned * (wall.segment<2>(i) - robot.head<2>());
    by_wall.block<2, 2>(i, i) = to_robot;
  }
}

SparseRows wall_rows(const ObservedWall& observed, const WallContext& at, MatchedEnds ends) {
  const Eigen::Vector4d seen = seen_from_robot(at.robot, at.wall);
  Eigen::Matrix<double, 4, 3> by_robot;
  Eigen::Matrix4d by_wall;
  seen_from_robot_jacobians(at.robot_first, at.wall_first, by_robot, by_wall);

  // Rows point along and across the map's wall, not the observed one: the observed direction's
  // error would enter both H and the innovation, and their product, always of one sign, would drag
  // the robot along the wall.
  const Eigen::Vector2d along = along_of(seen), across = turned_left(along);
  const Eigen::Vector2d along_first = along_of(seen_from_robot(at.robot_first, at.wall_first));
  const Eigen::Vector2d across_first = turned_left(along_first);
  SparseRows rows;
  rows.resize(2 + static_cast<int>(ends.start) + static_cast<int>(ends.end));
  rows.num_blocks = 2;
  rows.blocks = {0, at.block, 0};
  const auto add_row = [&](Eigen::Index row, Eigen::Index end, const Eigen::Vector2d& direction) {
    rows.jacobian.block<1, 3>(row, 0) = direction.transpose() * by_robot.middleRows<2>(end);
    rows.jacobian.block<1, 4>(row, 4) = direction.transpose() * by_wall.middleRows<2>(end);
  };
  Eigen::Matrix2d spread;  // of the two offsets by the line's offset and direction
  for (Eigen::Index i = 0; i < 2; ++i) {
    const Eigen::Vector2d end_m = seen.segment<2>(2 * i);
    const double from_center_m = observed.along().dot(end_m - observed.center_m);
    const Eigen::Vector2d on_line_m = observed.center_m + from_center_m * observed.along();
    add_row(i, 2 * i, across_first);
    rows.innovation(i) = across.dot(on_line_m - end_m);
    spread(i, 0) = observed.across_sigma_m;
    spread(i, 1) = observed.direction_sigma_rad * from_center_m;
  }
  rows.noise.topLeftCorner<2, 2>() = spread * spread.transpose();
  Eigen::Index row = 2;
  if (ends.start) {
    add_row(row, 0, along_first);
    rows.innovation(row) = along.dot(observed.start_m - seen.head<2>());
    rows.noise(row, row) = observed.start_sigma_m * observed.start_sigma_m;
    ++row;
  }
  if (ends.end) {
    add_row(row, 2, along_first);
    rows.innovation(row) = along.dot(observed.end_m - seen.tail<2>());
    rows.noise(row, row) = observed.end_sigma_m * observed.end_sigma_m;
  }
  return rows;
}

}  // namespace marco::slam
