#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/footprint.hpp"
#include "drivers/base/motion_forecast.hpp"
#include "drivers/base/surroundings.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers {

struct GuardOptions {
  bool enabled = true;
  /// The outline: x1, y1, x2, y2, ... from the turning centre, x ahead and y left.
  std::vector<double> body_m = Footprint::box(0.30, 0.30, 0.27);
  double margin_m = 0.10;                ///< kept free ahead on the way
  double side_margin_m = 0.03;           ///< kept free all around the body
  double min_height_m = 0.08;            ///< lower things are floor
  double max_height_m = 1.20;            ///< higher ones are passed under
  double braking_m_per_s2 = 0.3;         ///< the base brakes at least so hard
  double delay_s = 0.3;                  ///< from an order to the wheels, at most
  double without_sensors_m_per_s = 0.2;  ///< while no sensor shows what is in the way

  template <class Visitor>
  void visit(Visitor& v) {
    v("enabled", enabled);
    v("body_m", body_m);
    v("margin_m", margin_m, kNotNegative);
    v("side_margin_m", side_margin_m, kNotNegative);
    v("min_height_m", min_height_m);
    v("max_height_m", max_height_m, kPositive);
    v("braking_m_per_s2", braking_m_per_s2, kPositive);
    v("delay_s", delay_s, Limits{0.0, 2.0});
    v("without_sensors_m_per_s", without_sensors_m_per_s, kNotNegative);
  }
};

/// The last thing before the wheels: lets a base move as far as laser, sonars and bumpers show that
/// it may. It sweeps the body along the arc that an order leads to: what was sent and takes effect
/// yet, the order, and the braking after it.
///
/// Into ground that no sensor sees now it lets the base go no faster than 0.1 m/s, no farther than
/// half a metre, and only where in the last 30 s a sensor saw that it is free or the body covered
/// it. A turn on the spot is checked against what was seen alone. It knows nothing of glass, of
/// steps down, and of what is lower or higher than a laser's plane.
class ObstacleGuard {
 public:
  /// @throws std::invalid_argument naming the option.
  explicit ObstacleGuard(const GuardOptions& options);

  /// Call at each step, before the others.
  void note_time(Utime now) { around_.note_time(now); }
  void on_sensor_info(const SensorInfo& info) { around_.on_sensor_info(info); }
  void on_pantilt(const PanTiltState& state) { around_.on_pantilt(state); }
  void on_odometry(const OdometrySample& sample);
  /// As Surroundings.
  void on_scan(const LaserScan& scan, const Pose2& odom_from_robot, Utime now);
  void on_sonar(const SonarRing& ring,
                const Pose2& odom_from_robot,
                Utime now,
                Surroundings::Sonars read = Surroundings::Sonars::always);
  /// Numbers of those that are pressed, 1 = the leftmost as seen from within.
  void on_bumpers(std::vector<int> front_pressed, std::vector<int> rear_pressed);
  /// Their mounts, and what they saw. @returns the sensors' names, with commas.
  std::string forget_sensors() { return around_.forget(); }

  /// How a base drives.
  struct Drive {
    BaseDynamics dynamics;
    std::function<BaseVelocity(const BaseVelocity&)> as_driven;  ///< what it makes of an order
  };
  struct Verdict {
    BaseVelocity velocity;  ///< the largest part of the order, along its arc, that is allowed
    std::string why = {};   ///< it is not all of it
  };
  /// @param order  would be sent to the base now.
  Verdict judge(const BaseVelocity& order, const Drive& drive);
  /// The base gets this order, and no other until the next call.
  void on_sent(const BaseVelocity& order) { forecast_.on_sent(order, around_.now()); }
  /// It rests, and nothing that was sent is under way to its wheels.
  void on_rest() { forecast_.on_rest(); }

  struct FreeWay {
    double amount = 0.0;   ///< [m] or [rad], signed
    std::string why = {};  ///< it is not all that was wanted
    double speed_limit_m_per_s = std::numeric_limits<double>::infinity();
  };
  /// From standing. @param wanted_m  straight on, < 0 = backwards.
  FreeWay free_move(double wanted_m) const;
  /// @param wanted_rad  on the spot.
  FreeWay free_turn(double wanted_rad) const;
  /// Why a leg under way must be ended now; "" = it need not. @param speed  the leg's, along or
  /// about. @param remaining  of it [m or rad].
  std::string why_end_leg(const BaseVelocity& speed, double remaining, const Drive& drive);

  /// "LIDAR is silent for 0.7 s": nothing may move; "" = none is.
  std::string silent() const { return options_.enabled ? around_.silent() : ""; }
  /// Of the body's fastest point; infinity while a sensor shows what is in the way.
  double speed_limit_m_per_s() const;
  /// "front bumper 3 is pressed" for a move this way; "" = none is.
  std::string pressed_bumpers(double ahead) const;
  /// What a person has to know of it; "" = it sees.
  std::string words() const;
  double radius_m() const { return body_.radius_m(); }
  const GuardOptions& options() const { return options_; }

 private:
  using Points = std::vector<Eigen::Vector2d>;
  Sweep way_of(const BaseVelocity& order, const Drive& drive) const;
  void keep_margin(Sweep& sweep, const BaseVelocity& order) const;
  Points points_near(const Sweep& sweep) const;
  LocalMap::Ground ground_of(const Sweep& sweep, const BaseVelocity& velocity) const;
  std::string why_not(const Sweep& sweep, const BaseVelocity& order, const Points& points) const;
  std::pair<double, std::string> free_part(const BaseVelocity& order, const Drive& drive) const;
  FreeWay free_way(double wanted, const BaseVelocity& unit) const;
  FreeWay on_seen_ground(FreeWay free, const Sweep& sweep, const BaseVelocity& way) const;
  void note_drive(const Drive& drive);

  GuardOptions options_;
  Footprint body_;
  Surroundings around_;
  MotionForecast forecast_;
  std::vector<int> front_pressed_;
  std::vector<int> rear_pressed_;
  Pose2 odom_from_robot_;
  Utime measured_at_, judged_at_;
  double period_s_ = 0.0;  ///< from an order to the next
  double unseen_m_ = 0.0;  ///< driven in a row into ground that no sensor saw
};

}  // namespace marco::drivers
