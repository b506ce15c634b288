#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/footprint.hpp"
#include "common/pose_buffer.hpp"
#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "drivers/base/local_map.hpp"
#include "drivers/base/sensor_watch.hpp"

namespace marco::drivers {

/// What a base's lasers and sonars show of the floor around it. Scans are deskewed by the odometry.
class Surroundings {
 public:
  enum class Sonars { always, at_rest };  ///< when a base reads them
  static constexpr double kJumpM = 1.0;   ///< of the odometry: what was seen lies elsewhere

  Surroundings(const Footprint& body, const Heights& in_the_way)
      : body_(body), watch_(in_the_way) {}

  /// Call at each step, before the others.
  void note_time(Utime now) { now_ = now; }
  void on_sensor_info(const SensorInfo& info) { watch_.on_info(info, now_); }
  void on_pantilt(const PanTiltState& state) { watch_.on_pantilt(state, now_); }
  void on_odometry(const OdometrySample& sample);
  /// Ignored until the laser's SensorInfo has come. @param odom_from_robot  now: where the scan's
  /// stamp is not among those of the odometry.
  void on_scan(const LaserScan& scan, const Pose2& odom_from_robot, Utime now);
  /// Sonars that are read at rest alone are neither missed under way nor enough to drive by.
  void on_sonar(const SonarRing& ring, const Pose2& odom_from_robot, Utime now, Sonars read);
  /// All of it. @returns the sensors' names, with commas.
  std::string forget();

  /// Points that were hit, in the robot's frame.
  std::vector<Eigen::Vector2d> points_within(double reach_m) const;
  LocalMap::Ground ground_at(const Eigen::Vector2d& point_in_robot) const {
    return map_.ground_at(odom_from_robot_ * point_in_robot, now_);
  }
  /// As SensorWatch, now.
  std::string silent() const { return watch_.silent(now_); }
  std::string why_blind() const { return watch_.why_blind(now_); }
  std::string dispute() const { return watch_.dispute(now_); }
  Utime now() const { return now_; }

 private:
  struct SonarPoints {
    Utime when;
    std::vector<Eigen::Vector2d> in_odom;
  };
  SeenBeam beam_of(const SensorInfo& laser,
                   const Pose3& robot_from_laser,
                   double bearing_rad,
                   double range_m) const;
  std::vector<SeenBeam> beams_of(const LaserScan& scan,
                                 const SensorInfo& laser,
                                 const Pose3& robot_from_laser,
                                 const Pose2& odom_from_robot) const;

  Footprint body_;
  SensorWatch watch_;
  LocalMap map_;
  PoseBuffer odometry_{300};
  Pose2 odom_from_robot_;
  SonarPoints sonar_;
  Utime now_;
};

}  // namespace marco::drivers
