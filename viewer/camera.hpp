#pragma once

#include <Eigen/Core>
#include <string>

#include "common/pose3.hpp"
#include "viewer/scene.hpp"

namespace marco::viewer {

enum class Projection { perspective, orthographic };

/// From where and how a scene is seen. World: x, y on the floor, z up [m].
struct Camera {
  Eigen::Vector3d eye_m = Eigen::Vector3d(-5.0, 0.0, 3.0);
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();  ///< lies in the middle of the picture
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();       ///< not along the line of sight
  Projection projection = Projection::perspective;
  double field_of_view_rad = deg_to_rad(80.0);  ///< vertical; thesis B, app. C: gluPerspective(80)
  double view_height_m = 5.0;                   ///< orthographic: height of what is seen
  double near_m = 0.05;                         ///< along the line of sight
  double far_m = 200.0;
};

/// Maps world into the camera: x right, y up, -z ahead [m].
/// @throws std::invalid_argument when eye and target coincide or `up` points along the view.
Eigen::Matrix4d camera_from_world(const Camera& camera);

/// OpenGL's clip space from the camera's. @param aspect width / height of the picture.
/// @throws std::invalid_argument on 0 < near < far or 0 < field of view < 180 deg violated.
Eigen::Matrix4d clip_from_camera(const Camera& camera, double aspect);

/// Where a world point appears, pixels from the upper left corner; z = distance along the line of
/// sight [m], below 0 behind the eye.
Eigen::Vector3d project(const Camera& camera,
                        const Eigen::Vector3d& point_m,
                        int width_px,
                        int height_px);

/// Sees the whole box from the direction (azimuth, elevation) seen from its middle: azimuth 0 =
/// from +x, 90 deg = from +y; elevation 90 deg = from above. Near and far enclose the box.
/// @param camera gives projection and field of view.
/// @throws std::invalid_argument when the box is empty.
Camera fit_camera(
    Camera camera, const Box& box, double azimuth_rad, double elevation_rad, double aspect);

/// What a robot sees whose sensor stands at this pose: x ahead, z up.
Camera camera_at(const Pose3& world_from_sensor, double field_of_view_rad = deg_to_rad(80.0));

/// "x,y,z,yaw,pitch" [m, deg], pitch above 0 looks up; also "x,y,z,yaw".
/// @throws std::invalid_argument naming the text and what was expected.
Camera parse_camera(const std::string& text);

}  // namespace marco::viewer
