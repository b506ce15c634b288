#include "common/files/points/scan_pose.hpp"

#include <cmath>
#include <vector>

#include "common/files/points/point_files.hpp"
#include "common/files/points/text_writer.hpp"
#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

constexpr double kRoundingOfFiles = 1e-3;  // matrices in files have few digits

// x forward, y left, z up from 3DTK's x right, y up, z ahead.
Eigen::Matrix3d ours_from_uos() {
  Eigen::Matrix3d axes;
  axes << 0, 0, 1, -1, 0, 0, 0, 1, 0;
  return axes;
}

Eigen::Matrix3d turn(double angle_rad, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

// 3DTK's EulerToMatrix4: Rx · Ry · Rz of the usual matrices, in left-handed coordinates.
Pose3 pose_of_uos(const Eigen::Vector3d& position_cm, const Eigen::Vector3d& angles_deg) {
  const Eigen::Vector3d rad = angles_deg * (M_PI / 180.0);
  const Eigen::Matrix3d in_uos = turn(rad.x(), Eigen::Vector3d::UnitX()) *
                                 turn(rad.y(), Eigen::Vector3d::UnitY()) *
                                 turn(rad.z(), Eigen::Vector3d::UnitZ());
  Pose3 pose = Pose3::Identity();
  pose.linear() = ours_from_uos() * in_uos * ours_from_uos().transpose();
  pose.translation() = 0.01 * (ours_from_uos() * position_cm);
  return pose;
}

// Where y is a right angle x may be any: the others follow from the one that is taken.
Eigen::Vector3d uos_angles_deg(const Eigen::Matrix3d& in_uos) {
  const double x = std::atan2(-in_uos(1, 2), in_uos(2, 2));
  const Eigen::Matrix3d rest = turn(-x, Eigen::Vector3d::UnitX()) * in_uos;  // Ry · Rz
  return Eigen::Vector3d(x, std::atan2(rest(0, 2), rest(2, 2)),
                         std::atan2(rest(1, 0), rest(1, 1))) *
         (180.0 / M_PI);
}

}  // namespace

Pose3 quaternion_pose(const Eigen::Vector3d& position_m,
                      const Eigen::Vector4d& wxyz,
                      const std::string& name) {
  require(position_m.allFinite() && std::abs(wxyz.norm() - 1.0) < kRoundingOfFiles,
          name + ": its pose is not a position and rotation");
  Pose3 pose = Pose3::Identity();
  pose.linear() =
      Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix();
  pose.translation() = position_m;
  return pose;
}

Pose3 rigid_pose(const Eigen::Matrix4d& matrix, const std::string& name) {
  const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
  const bool is_rigid =
      matrix.allFinite() && matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-9) &&
      (linear * linear.transpose()).isIdentity(kRoundingOfFiles) && linear.determinant() > 0.0;
  require(is_rigid, name + ": the matrix of its pose is not a rotation and translation");
  const Eigen::Quaterniond turned(linear);
  return quaternion_pose(matrix.topRightCorner<3, 1>(),
                         {turned.w(), turned.x(), turned.y(), turned.z()}, name);
}

std::filesystem::path pose_path_of(const std::filesystem::path& points) {
  return std::filesystem::path(points).replace_extension(".pose");
}

std::optional<Pose3> read_scan_pose(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::nullopt;
  const std::string name = path.string();
  std::vector<double> n;
  for (const NumericRow& row : read_numeric_rows(name)) {
    n.insert(n.end(), row.numbers.begin(), row.numbers.end());
  }
  if (n.size() == 6) return pose_of_uos({n[0], n[1], n[2]}, {n[3], n[4], n[5]});
  if (n.size() == 8) n.erase(n.begin());  // the stamp
  if (n.size() == 7) return quaternion_pose({n[0], n[1], n[2]}, {n[6], n[3], n[4], n[5]}, name);
  require(
      n.size() == 12 || n.size() == 16,
      name + ": expected a pose of 6, 7, 8, 12 or 16 numbers, found " + std::to_string(n.size()));
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < n.size(); ++i) {
    matrix(static_cast<int>(i / 4), static_cast<int>(i % 4)) = n[i];
  }
  return rigid_pose(matrix, name);
}

void write_scan_pose(const std::filesystem::path& path, const Pose3& world_from_scanner) {
  const Eigen::Matrix3d axes = ours_from_uos();
  const Eigen::Vector3d cm = 100.0 * (axes.transpose() * world_from_scanner.translation());
  const Eigen::Vector3d deg = uos_angles_deg(axes.transpose() * world_from_scanner.linear() * axes);
  TextWriter text;
  for (int i = 0; i < 3; ++i) text.number(cm[i], i < 2 ? ' ' : '\n');
  for (int i = 0; i < 3; ++i) text.number(deg[i], i < 2 ? ' ' : '\n');
  write_whole_file(path, text.text());
}

}  // namespace marco::files
