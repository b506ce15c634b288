#include "viewer/camera.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <sstream>

#include "lcm_tools/base/check.hpp"

namespace marco::viewer {
namespace {

// How much larger than the box the view is.
constexpr double kFitMargin = 1.04;

std::array<Eigen::Vector3d, 8> corners_of(const Box& box) {
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      corners[i][axis] = ((i >> axis) & 1U) != 0 ? box.max_m[axis] : box.min_m[axis];
  return corners;
}

Eigen::Vector3d in_camera(const Eigen::Matrix4d& from_world, const Eigen::Vector3d& point_m) {
  return (from_world * point_m.homogeneous()).head<3>();
}

}  // namespace

Eigen::Matrix4d camera_from_world(const Camera& camera) {
  const Eigen::Vector3d ahead = camera.target_m - camera.eye_m;
  const Eigen::Vector3d sideways = ahead.cross(camera.up);
  require(ahead.norm() > 0.0 && ahead.allFinite(), "a camera's eye and target must differ");
  require(sideways.norm() > 1e-9 * ahead.norm(),
          "a camera's `up` must not be parallel to its view");
  const Eigen::Vector3d back = -ahead.normalized();
  const Eigen::Vector3d right = sideways.normalized();
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.row(0).head<3>() = right;
  matrix.row(1).head<3>() = back.cross(right);
  matrix.row(2).head<3>() = back;
  matrix.topRightCorner<3, 1>() = -matrix.topLeftCorner<3, 3>() * camera.eye_m;
  return matrix;
}

Eigen::Matrix4d clip_from_camera(const Camera& camera, double aspect) {
  require(camera.near_m < camera.far_m && aspect > 0.0, "a camera needs near < far, aspect > 0");
  const double near = camera.near_m, far = camera.far_m;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  if (camera.projection == Projection::orthographic) {
    require(camera.view_height_m > 0.0, "an orthographic camera needs view_height_m > 0");
    matrix(0, 0) = 2.0 / (camera.view_height_m * aspect);
    matrix(1, 1) = 2.0 / camera.view_height_m;
    matrix(2, 2) = -2.0 / (far - near);
    matrix(2, 3) = -(far + near) / (far - near);
    matrix(3, 3) = 1.0;
    return matrix;
  }
  require(near > 0.0, "a perspective camera needs near_m > 0");
  require(camera.field_of_view_rad > 0.0 && camera.field_of_view_rad < std::numbers::pi,
          "a camera's field of view must be between 0 and 180 deg");
  const double focal = 1.0 / std::tan(0.5 * camera.field_of_view_rad);
  matrix(0, 0) = focal / aspect;
  matrix(1, 1) = focal;
  matrix(2, 2) = -(far + near) / (far - near);
  matrix(2, 3) = -2.0 * far * near / (far - near);
  matrix(3, 2) = -1.0;
  return matrix;
}

Eigen::Vector3d project(const Camera& camera,
                        const Eigen::Vector3d& point_m,
                        int width_px,
                        int height_px) {
  const Eigen::Matrix4d from_world = camera_from_world(camera);
  const double aspect = static_cast<double>(width_px) / height_px;
  const Eigen::Vector4d clip =
      clip_from_camera(camera, aspect) * from_world * point_m.homogeneous();
  const Eigen::Vector2d ndc = clip.head<2>() / clip.w();
  return {0.5 * (1.0 + ndc.x()) * width_px, 0.5 * (1.0 - ndc.y()) * height_px,
          -in_camera(from_world, point_m).z()};
}

Camera fit_camera(
    Camera camera, const Box& box, double azimuth_rad, double elevation_rad, double aspect) {
  require(!box.empty(), "a camera cannot be fitted to an empty box");
  const Eigen::Vector3d towards_eye(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                    std::cos(elevation_rad) * std::sin(azimuth_rad),
                                    std::sin(elevation_rad));
  camera.up = std::abs(towards_eye.z()) < 0.999
                  ? Eigen::Vector3d::UnitZ()
                  : Eigen::Vector3d(-std::cos(azimuth_rad), -std::sin(azimuth_rad), 0.0);
  camera.target_m = box.center_m();
  camera.eye_m = box.center_m() + towards_eye;
  const Eigen::Matrix4d from_world = camera_from_world(camera);
  const bool perspective = camera.projection == Projection::perspective;

  // Along each picture axis every corner must lie between two lines through the eye, of slope
  // `tangent` (0 when orthographic); the extreme corners on both sides fix the eye (a, depth).
  const double vertical = perspective ? std::tan(0.5 * camera.field_of_view_rad) / kFitMargin : 0.0;
  const Eigen::Vector2d tangent(vertical * aspect, vertical);
  Eigen::Vector2d positive = Eigen::Vector2d::Constant(-1e300), negative = positive;
  for (const Eigen::Vector3d& corner : corners_of(box)) {
    const Eigen::Vector3d seen = in_camera(from_world, corner);
    positive = positive.cwiseMax(seen.head<2>() + tangent * seen.z());
    negative = negative.cwiseMax(-seen.head<2>() + tangent * seen.z());
  }
  const Eigen::Vector2d middle = 0.5 * (positive - negative), half = 0.5 * (positive + negative);
  const double radius = std::max(0.5 * box.size_m().norm(), 0.01);
  double depth = 2.0 * radius;
  if (perspective)
    depth = half.cwiseQuotient(tangent).maxCoeff();
  else
    camera.view_height_m = std::max(2.0 * kFitMargin * std::max(half.y(), half.x() / aspect), 1e-3);

  const Eigen::Matrix3d world_from_camera = from_world.topLeftCorner<3, 3>().transpose();
  camera.eye_m += world_from_camera * Eigen::Vector3d(middle.x(), middle.y(), depth);
  const double distance = (camera.eye_m - box.center_m()).dot(towards_eye);
  camera.target_m = camera.eye_m - distance * towards_eye;
  camera.near_m = std::max(0.01 * radius, distance - 1.2 * radius);
  camera.far_m = distance + 4.0 * radius;
  return camera;
}

Camera camera_at(const Pose3& world_from_sensor, double field_of_view_rad) {
  Camera camera;
  camera.eye_m = world_from_sensor.translation();
  camera.target_m = world_from_sensor * Eigen::Vector3d::UnitX();
  camera.up = world_from_sensor.linear() * Eigen::Vector3d::UnitZ();
  camera.field_of_view_rad = field_of_view_rad;
  return camera;
}

Camera parse_camera(const std::string& text) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  std::string part;
  bool good = true;
  while (std::getline(stream, part, ',')) {
    std::size_t used = 0;
    try {
      numbers.push_back(std::stod(part, &used));
    } catch (const std::exception&) {
      good = false;
    }
    good = good && part.find_first_not_of(" \t", used) == std::string::npos &&
           std::isfinite(numbers.empty() ? 0.0 : numbers.back());
  }
  require(
      good && (numbers.size() == 4 || numbers.size() == 5),
      "camera \"" + text +
          "\": expected above, eye, front, robot, sheet, or x,y,z,yaw,pitch in metres and degrees");
  numbers.resize(5, 0.0);
  return camera_at(make_pose3({numbers[0], numbers[1], numbers[2]}, 0.0, -deg_to_rad(numbers[4]),
                              deg_to_rad(numbers[3])));
}

}  // namespace marco::viewer
