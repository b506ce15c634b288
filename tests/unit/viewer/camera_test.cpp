#include "viewer/camera.hpp"

#include <gtest/gtest.h>

#include <array>

namespace marco::viewer {
namespace {

// Projection is a handful of products of numbers around 10.
constexpr double kTolerancePx = 1e-6;

TEST(Camera, PutsItsTargetInTheMiddleAndLeftOfTheRobotLeft) {
  const Camera camera = camera_at(make_pose3({1.0, 2.0, 0.5}, 0.0, 0.0, deg_to_rad(90.0)));
  const Eigen::Vector3d ahead = project(camera, {1.0, 5.0, 0.5}, 200, 100);
  EXPECT_NEAR(ahead.x(), 100.0, kTolerancePx);
  EXPECT_NEAR(ahead.y(), 50.0, kTolerancePx);
  EXPECT_NEAR(ahead.z(), 3.0, 1e-9);
  EXPECT_LT(project(camera, {0.0, 5.0, 0.5}, 200, 100).x(), 100.0);
  EXPECT_LT(project(camera, {1.0, 5.0, 1.5}, 200, 100).y(), 50.0);
  EXPECT_LT(project(camera, {1.0, 0.0, 0.5}, 200, 100).z(), 0.0);
}

TEST(Camera, VerticalFieldOfViewEndsAtThePicturesEdges) {
  const Camera camera = camera_at(make_pose3({0.0, 0.0, 0.0}), deg_to_rad(80.0));
  const double height = 2.0 * std::tan(deg_to_rad(40.0));
  EXPECT_NEAR(project(camera, {2.0, 0.0, height}, 200, 100).y(), 0.0, kTolerancePx);
  EXPECT_NEAR(project(camera, {2.0, 0.0, -height}, 200, 100).y(), 100.0, kTolerancePx);
}

// OpenGL keeps what lies between -1 (near) and 1 (far), and hides the farther by the nearer.
TEST(Camera, ClipsDepthFromNearToFar) {
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    Camera camera;
    camera.projection = projection;
    camera.near_m = 0.5;
    camera.far_m = 20.0;
    const Eigen::Matrix4d clip_from = clip_from_camera(camera, 1.5);
    const auto depth = [&](double distance_m) {
      const Eigen::Vector4d clip = clip_from * Eigen::Vector4d(0.1, -0.2, -distance_m, 1.0);
      return clip.z() / clip.w();
    };
    EXPECT_NEAR(depth(0.5), -1.0, 1e-12);
    EXPECT_NEAR(depth(20.0), 1.0, 1e-12);
    double last = -1.0;
    for (const double distance_m : {0.6, 1.0, 2.0, 5.0, 10.0, 19.0}) {
      EXPECT_GT(depth(distance_m), last);
      last = depth(distance_m);
    }
    // A middle one: (f + n - 2 f n / d) / (f - n) of perspective, linear otherwise.
    const double middle = projection == Projection::perspective
                              ? (20.5 - 2.0 * 20.0 * 0.5 / 4.0) / 19.5
                              : 2.0 * (4.0 - 0.5) / 19.5 - 1.0;
    EXPECT_NEAR(depth(4.0), middle, 1e-12);
  }
}

TEST(Camera, FitsABoxTightlyFromEveryDirection) {
  Box box;
  box.add({-1.0, 2.0, 0.0});
  box.add({7.0, 5.0, 2.5});
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    for (const double azimuth_deg : {-66.0, 0.0, 135.0}) {
      for (const double elevation_deg : {0.0, 14.0, 52.0, 90.0}) {
        Camera camera;
        camera.projection = projection;
        camera.field_of_view_rad = deg_to_rad(35.0);
        camera =
            fit_camera(camera, box, deg_to_rad(azimuth_deg), deg_to_rad(elevation_deg), 16.0 / 9.0);
        Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
        for (int i = 0; i < 8; ++i) {
          const Eigen::Vector3d corner((i & 1) != 0 ? 7.0 : -1.0, (i & 2) != 0 ? 5.0 : 2.0,
                                       (i & 4) != 0 ? 2.5 : 0.0);
          const Eigen::Vector3d seen = project(camera, corner, 1600, 900);
          EXPECT_GT(seen.z(), camera.near_m);
          EXPECT_LT(seen.z(), camera.far_m);
          low = low.cwiseMin(seen.head<2>());
          high = high.cwiseMax(seen.head<2>());
        }
        EXPECT_GE(low.minCoeff(), 0.0);
        EXPECT_LE(high.x(), 1600.0);
        EXPECT_LE(high.y(), 900.0);
        // One of the sides is filled but for the margin of 4 %.
        EXPECT_GT(std::max((high.x() - low.x()) / 1600.0, (high.y() - low.y()) / 900.0), 0.93);
      }
    }
  }
}

TEST(Camera, ReadsAPoseInMetresAndDegrees) {
  const Camera camera = parse_camera("1, 2,0.5,90,30");
  const Eigen::Vector3d direction = camera.target_m - camera.eye_m;
  EXPECT_NEAR(camera.eye_m.y(), 2.0, 1e-12);
  EXPECT_NEAR(direction.x(), 0.0, 1e-12);
  EXPECT_NEAR(direction.z(), 0.5, 1e-12);  // sin 30 deg, upwards
  for (const char* bad : {"", "1,2,3", "1,2,3,4,5,6", "1,2,x,4", "1,2,3,4z", "nan,1,2,3", "1,,2,3"})
    EXPECT_THROW(parse_camera(bad), std::invalid_argument) << bad;
}

TEST(Camera, RefusesWhatCannotBeSeen) {
  Camera camera;
  camera.target_m = camera.eye_m;
  EXPECT_THROW(camera_from_world(camera), std::invalid_argument);
  camera.target_m = camera.eye_m + Eigen::Vector3d::UnitZ();
  EXPECT_THROW(camera_from_world(camera), std::invalid_argument);
  camera.near_m = 0.0;
  EXPECT_THROW(clip_from_camera(camera, 1.0), std::invalid_argument);
  EXPECT_THROW(fit_camera({}, {}, 0.0, 0.0, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace marco::viewer
