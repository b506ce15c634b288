#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/pose2.hpp"

namespace marco {

/// What a robot covers of the floor: a simple polygon in the robot's frame, whose origin is the
/// turning centre. Const: safe from several threads.
class Footprint {
 public:
  /// @param corners_m  x1, y1, x2, y2, ... along the outline, either way round.
  /// @throws std::invalid_argument unless there are 3 to 64 corners within 20 m of the origin, no
  /// edges touch but at the corner they share, and there is an area.
  explicit Footprint(const std::vector<double>& corners_m);

  /// The corners of a box about the turning centre.
  static std::vector<double> box(double front_m, double back_m, double half_width_m);

  /// From the outline to a point of the robot's frame [m], < 0 inside. Exact.
  double distance_m(const Eigen::Vector2d& point) const;
  /// Of the circle about the turning centre that holds the body.
  double radius_m() const { return radius_m_; }
  /// The farthest corner ahead, and behind (> 0 where the body reaches behind the origin).
  double front_m() const { return front_m_; }
  double back_m() const { return back_m_; }
  /// The larger of left and right.
  double half_width_m() const { return half_width_m_; }
  const std::vector<Eigen::Vector2d>& corners_m() const { return corners_m_; }

 private:
  std::vector<Eigen::Vector2d> corners_m_;
  double radius_m_ = 0.0, front_m_ = 0.0, back_m_ = 0.0, half_width_m_ = 0.0;
};

/// A body under way.
struct SweptPose {
  Pose2 start_from_robot;
  double swept_m = 0.0;  ///< since the start: at least the way of the body's fastest point
};
using Sweep = std::vector<SweptPose>;

/// Appends a step. @param moved  in the frame of the sweep's end.
void advance(Sweep& sweep, const Pose2& moved, double radius_m);

/// The first pose of a sweep at which the body comes nearer than `margin_m` to one of the points.
/// A point that is so near at the start already may come no nearer (by a millimetre, and not into
/// the body).
/// @param points  in the frame of the sweep's start. @returns sweep.size() = none.
/// Exact at the poses; steps are to be small against the margin. Cost O(points) and a few distances
/// for each that is near the way: of the rest the swept length says that it cannot be met.
std::size_t first_contact(const Footprint& body,
                          std::span<const SweptPose> sweep,
                          std::span<const Eigen::Vector2d> points,
                          double margin_m);

}  // namespace marco
