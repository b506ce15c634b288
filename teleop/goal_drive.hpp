#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/robot_values.hpp"

namespace marco::teleop {

/// A drive to a point of the map. A base goes by its odometry, which is off by some percent of the
/// way; so the order is given again from where SLAM sees the robot, until it stands near enough or
/// comes no nearer. Pure.
class GoalDrive {
 public:
  static constexpr double kNearM = 0.05;

  /// @param goal_m  in the map's frame
  explicit GoalDrive(const Eigen::Vector2d& goal_m) : goal_m_(goal_m) {}

  const Eigen::Vector2d& goal_m() const { return goal_m_; }
  /// The order to go there was given, under this id.
  void on_ordered(int64_t id) {
    id_ = id;
    is_taken_ = false;
    ++legs_;
  }
  bool is_taken() const { return is_taken_; }

  enum class Next {
    wait,
    again,  ///< the order is to be given again
    there,
    ended  ///< the base refused it, gave it up, or obeys another order; its note says why
  };
  /// @param distance_m  to the goal, as SLAM sees it now
  Next on_status(const BaseStatus& status, double distance_m);

 private:
  Eigen::Vector2d goal_m_;
  int64_t id_ = 0;
  bool is_taken_ = false;
  int legs_ = 0;
  double nearest_m_ = 0.0;  ///< after the leg before
};

}  // namespace marco::teleop
