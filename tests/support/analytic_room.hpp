#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "mapping3d/scene.hpp"

namespace marco::testing {

/// A room of 8 x 6 x 2.8 m with three boxes in it, to be scanned by arithmetic.
class AnalyticRoom {
 public:
  /// Distance along `direction` (unit) from `origin_m` inside the room to what it meets first.
  static double range_m(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) {
    double nearest_m = leave(origin_m, direction, {-4.0, -3.0, 0.0}, {4.0, 3.0, 2.8});
    nearest_m = std::min(nearest_m, enter(origin_m, direction, {2.2, 0.6, 0.0}, {3.1, 1.9, 1.1}));
    nearest_m = std::min(nearest_m, enter(origin_m, direction, {1.0, -2.4, 0.0}, {1.8, -1.5, 0.7}));
    return std::min(nearest_m, enter(origin_m, direction, {3.0, -1.4, 0.0}, {3.6, -0.6, 2.0}));
  }

  /// A sweep of 361 beams by `rows` tilts from -20 to 45 deg, by a sensor that stands still.
  static mapping3d::Scene sweep(const Pose3& world_from_sensor,
                                std::size_t rows,
                                double sigma_m,
                                std::mt19937& random) {
    std::normal_distribution<double> noise(0.0, 1.0);
    mapping3d::Scene scene;
    for (std::size_t row = 0; row < rows; ++row) {
      const double tilt_deg = -20.0 + 65.0 * static_cast<double>(row) / static_cast<double>(rows);
      mapping3d::SceneRow line;
      line.utime = Utime::from_us(static_cast<int64_t>(row) * 26667);
      line.first_bearing_rad = deg_to_rad(-90.0);
      line.bearing_step_rad = deg_to_rad(0.5);
      line.robot_from_sensor_first =
          world_from_sensor * make_pose3(Eigen::Vector3d::Zero(), 0.0, -deg_to_rad(tilt_deg), 0.0);
      line.robot_from_sensor_last = line.robot_from_sensor_first;
      for (int beam = 0; beam < 361; ++beam) {
        const double bearing = line.first_bearing_rad + beam * line.bearing_step_rad;
        const Eigen::Vector3d direction = line.robot_from_sensor_first.linear() *
                                          Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0);
        const double true_m = range_m(world_from_sensor.translation(), direction);
        line.ranges_m.push_back(static_cast<float>(true_m + sigma_m * noise(random)));
      }
      scene.rows.push_back(line);
    }
    return scene;
  }

  /// Largest shift of a corner of the room by what is left of an error.
  static double worst_shift_m(const Pose3& left) {
    double worst = 0.0;
    for (const double x : {-4.0, 4.0}) {
      for (const double y : {-3.0, 3.0}) {
        const Eigen::Vector3d corner(x, y, 1.4);
        worst = std::max(worst, (left * corner - corner).norm());
      }
    }
    return worst;
  }

  /// 90 % of the points that lie on the room's walls, floor and ceiling are nearer to them.
  static double p90_off_m(const mapping3d::ScenePoints& scene) {
    std::vector<double> off_m;
    for (std::size_t i = 0; i < scene.points_m.size(); ++i) {
      const Eigen::Vector3d p = scene.points_m[i].cast<double>();
      const double nearest_m =
          std::min({std::abs(std::abs(p.x()) - 4.0), std::abs(std::abs(p.y()) - 3.0),
                    std::abs(p.z()), std::abs(p.z() - 2.8)});
      if (nearest_m < 0.2) off_m.push_back(nearest_m);  // what is farther off lies on a box
    }
    const auto place = off_m.begin() + static_cast<std::ptrdiff_t>(off_m.size() * 9 / 10);
    std::nth_element(off_m.begin(), place, off_m.end());
    return *place;
  }

 private:
  struct Span {
    double in_m;
    double out_m;
  };
  static Span cross(const Eigen::Vector3d& origin_m,
                    const Eigen::Vector3d& direction,
                    const Eigen::Vector3d& low_m,
                    const Eigen::Vector3d& high_m) {
    Span span{-1e9, 1e9};
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (low_m[axis] - origin_m[axis]) / direction[axis];
      const double b = (high_m[axis] - origin_m[axis]) / direction[axis];
      span.in_m = std::max(span.in_m, std::min(a, b));
      span.out_m = std::min(span.out_m, std::max(a, b));
    }
    return span;
  }
  static double leave(const Eigen::Vector3d& origin_m,
                      const Eigen::Vector3d& direction,
                      const Eigen::Vector3d& low_m,
                      const Eigen::Vector3d& high_m) {
    return cross(origin_m, direction, low_m, high_m).out_m;
  }
  static double enter(const Eigen::Vector3d& origin_m,
                      const Eigen::Vector3d& direction,
                      const Eigen::Vector3d& low_m,
                      const Eigen::Vector3d& high_m) {
    const Span span = cross(origin_m, direction, low_m, high_m);
    return span.in_m > 0.0 && span.in_m <= span.out_m ? span.in_m : 1e9;
  }
};

}  // namespace marco::testing
