#pragma once

#include <random>

#include "common/pose3.hpp"
#include "simulator/live/robot_spec.hpp"
#include "simulator/ray_caster.hpp"

namespace marco::sim {

/// Which side of the body touches something.
struct Contact {
  bool front = false;
  bool rear = false;
  bool blocked = false;      ///< the wheels turned and the robot did not move
  double bearing_rad = 0.0;  ///< of the touch, robot frame
  bool any() const { return front || rear; }
};

/// Where the wheels really take the robot, given the floor, slip and walls. The counterpart of
/// OdometryModel.
class FloorMotion {
 public:
  /// @param rays outlives the motion.
  FloorMotion(const RayCaster& rays,
              const BodySpec& body,
              const OdometryOptions& wheels,
              const Pose2& start,
              uint64_t seed);

  /// The wheels have turned by this much more.
  void roll(double left_m, double right_m, double track_m);

  const Pose2& world_from_robot() const { return world_from_robot_; }
  const Contact& contact() const { return contact_; }

 private:
  /// Distance from the body's rim to the nearest surface, and where.
  double clearance_m(const Pose2& world_from_robot, double* bearing_rad) const;

  const RayCaster& rays_;
  BodySpec body_;
  OdometryOptions wheels_;
  std::mt19937_64 random_;
  double distance_scale_;
  double turn_scale_;
  double drift_rad_per_m_;
  double to_next_slip_m_;
  double slip_left_m_ = 0.0;
  Pose2 world_from_robot_;
  Contact contact_;
};

}  // namespace marco::sim
