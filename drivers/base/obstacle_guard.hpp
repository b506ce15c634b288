#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers {

struct GuardOptions {
  bool enabled = true;
  double front_m = 0.30;  ///< of the body, from the turning centre
  double back_m = 0.30;
  double half_width_m = 0.27;
  double margin_m = 0.10;       ///< kept free ahead and behind
  double side_margin_m = 0.03;  ///< kept free beside the body
  double min_height_m = 0.08;   ///< lower things are floor
  double max_height_m = 1.20;   ///< higher ones are passed under
  double max_age_s = 60.0;      ///< of the last reading of a sensor that has failed

  template <class Visitor>
  void visit(Visitor& v) {
    v("enabled", enabled);
    v("front_m", front_m, kPositive);
    v("back_m", back_m, kPositive);
    v("half_width_m", half_width_m, kPositive);
    v("margin_m", margin_m, kNotNegative);
    v("side_margin_m", side_margin_m, kNotNegative);
    v("min_height_m", min_height_m);
    v("max_height_m", max_height_m, kPositive);
    v("max_age_s", max_age_s, kPositive);
  }
};

/// Collision guard: how far a robot may go before it meets what its laser, sonars and bumpers saw.
/// Each sensor's points stay in the odom frame until its next reading, at most max_age_s: a wall
/// remains when the laser fails in front of it. Without any readings the way counts as free,
/// because a robot without a laser must be drivable; see blind().
class ObstacleGuard {
 public:
  explicit ObstacleGuard(const GuardOptions& options);

  void on_sensor_info(const SensorInfo& info) { infos_[info.channel] = info; }
  void on_pantilt(const PanTiltState& state) { pantilt_ = state; }
  /// Ignored until the laser's SensorInfo has come.
  void on_scan(const LaserScan& scan, const Pose2& odom_from_robot, Utime now);
  void on_sonar(const SonarRing& ring, const Pose2& odom_from_robot, Utime now);
  /// Numbers of those that are pressed, 1 = the leftmost as seen from within.
  void on_bumpers(std::vector<int> front_pressed, std::vector<int> rear_pressed);

  /// @param wanted_m  straight on, < 0 = backwards. @returns the part that is free, same sign.
  double free_move_m(double wanted_m, const Pose2& odom_from_robot, Utime now) const;
  /// @param wanted_rad  on the spot. @returns the part that is free, same sign.
  double free_turn_rad(double wanted_rad, const Pose2& odom_from_robot, Utime now) const;

  /// "front bumper 3 is pressed" for a move this way; "" = none is.
  std::string pressed_bumpers(double wanted_m) const;

  bool blind(Utime now) const;
  const GuardOptions& options() const { return options_; }

 private:
  struct Sight {
    Utime when;
    std::vector<Eigen::Vector2d> points_in_odom;
  };
  std::vector<Eigen::Vector2d> fresh_points(const Pose2& odom_from_robot, Utime now) const;
  bool in_body(const Eigen::Vector2d& point, double margin_m, double side_margin_m) const;

  GuardOptions options_;
  std::map<std::string, SensorInfo> infos_;
  std::optional<PanTiltState> pantilt_;
  std::map<std::string, Sight> sights_;
  std::vector<int> front_pressed_;
  std::vector<int> rear_pressed_;
};

}  // namespace marco::drivers
