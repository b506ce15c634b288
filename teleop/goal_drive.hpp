#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "common/robot_values.hpp"

namespace marco::teleop {

/// A drive to a point: a turn towards it, then straight on, from where the robot is seen now. It
/// consists of velocities, which a base drops after half a second (kOrderHoldsS): whatever becomes
/// of their sender, the robot drives no further. The base's own guard slows it before obstacles.
/// Pure.
class GoalDrive {
 public:
  static constexpr double kNearM = 0.05;
  static constexpr double kSendEveryS = 0.05;

  struct Speeds {
    double most_m_per_s = 0.4, most_rad_per_s = 0.8;
  };

  /// @param id  of its orders
  GoalDrive(int64_t id, const Speeds& speeds, Utime now);

  /// Call each kSendEveryS; it ends when nobody did for half a second.
  /// @param goal_m  as the robot sees it: x ahead, y to its left
  /// @returns the order to send now; nothing: it is over, and a stop is to be sent unless
  /// is_taken_over().
  std::optional<BaseCommand> next(const Eigen::Vector2d& goal_m, Utime now);
  /// The same while the robot shall stand for a moment.
  std::optional<BaseCommand> hold(Utime now);
  /// What the base says of its orders, ours and others'.
  void on_status(const BaseStatus& status);

  /// Why it ended elsewhere than at the goal; "" while it drives, and there.
  const std::string& why_ended() const { return why_ended_; }
  /// It ended since the base obeys another, whom a stop of ours would end.
  bool is_taken_over() const { return is_taken_over_; }

 private:
  enum class Phase { turn, move, settle };

  void enter(Phase phase, Utime now);
  void end(const std::string& why);
  bool keeps_up(Utime now);
  void watch(double left, Utime now);
  bool is_there(double distance_m);
  BaseCommand order(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) const;

  int64_t id_;
  Speeds speeds_;
  Utime begun_, called_;
  bool is_taken_ = false, is_over_ = false, is_taken_over_ = false;
  std::string why_ended_, note_;  ///< the note is the base's
  Phase phase_ = Phase::turn;
  Utime entered_;
  struct Progress {
    double least_left = 0.0;  ///< of the phase: rad of a turn, m of a move
    Utime at;
  } progress_;
  int approaches_ = 0;
  double nearest_m_ = 0.0;  ///< after the approach before
};

}  // namespace marco::teleop
