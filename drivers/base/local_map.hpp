#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "common/footprint.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// Whether something happened, and no longer ago than that. A clock that was set back counts as
/// now.
inline bool is_within(double seconds, Utime when, Utime now) {
  return when != Utime{} && std::abs((now - when).seconds()) <= seconds;
}

/// A beam of a laser.
struct SeenBeam {
  enum class End {
    hit,        ///< at `range_m`
    far,        ///< nothing as far as the laser sees
    no_answer,  ///< nothing came back: too far, too dark, or glass
    nothing  ///< it is not known what it saw: the robot itself, or what is nearer than it measures
  };

  Eigen::Vector3d from_m;  ///< where the laser was
  Eigen::Vector3d along;   ///< unit vector
  double range_m = 0.0;
  End end = End::nothing;

  Eigen::Vector3d tip_m() const { return from_m + range_m * along; }
};

/// Where a beam, or what it hits, is in the way of the body.
struct Heights {
  double lowest_m = 0.0, highest_m = 0.0;
  bool contain(double z_m) const { return z_m >= lowest_m && z_m <= highest_m; }
};

/// What is known of the floor around a robot: where something was hit last, and what was seen or
/// covered by the body and when. Odom frame, 4 m about the robot; memory is constant.
///
/// A point that was hit stays for 30 s, whether a sensor looks there or not, unless the robot
/// stands there, or three scans pass it: a beam within a centimetre of the very point ends
/// clearly behind it, and so do the beams beside it. What grazes a wall or misses a thin leg takes
/// nothing away.
class LocalMap {
 public:
  static constexpr double kReachM = 4.0;
  static constexpr double kRememberedS = 30.0;

  LocalMap();
  void clear() { *this = LocalMap(); }

  /// The robot is at `odom_from_robot`: what the body covers is free.
  void on_body(const Footprint& body, const Pose2& odom_from_robot, Utime now);
  /// The beams of one scan, odom frame, in the order of their bearings.
  void on_beams(std::span<const SeenBeam> beams, const Heights& counted, Utime now);
  /// Marks what lies between two points as seen. Takes no points away.
  void on_ray(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, Utime now);

  /// Points that were hit, as far as `reach_m` about the robot and in its frame.
  std::vector<Eigen::Vector2d> points_about(const Pose2& odom_from_robot,
                                            double reach_m,
                                            Utime now) const;

  enum class Ground { unknown, remembered, seen };
  /// Of a point of the odom frame: whether a sensor sees the place now (shadows of 25 cm count as
  /// seen), has seen it in the last 30 s or the body covered it then, or not.
  Ground ground_at(const Eigen::Vector2d& point_m, Utime now) const;

 private:
  struct Hit {
    Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
    Utime when;      ///< 0 = none
    int passes = 0;  ///< of scans since then
  };
  struct Place {
    int32_t x = 0, y = 0;  ///< which of the places that share this entry
    Utime seen, covered;
  };
  Place& place_at(double x_m, double y_m);
  void see(const SeenBeam& beam, const Heights& counted, Utime now);
  void pass_points(std::span<const SeenBeam> beams);
  void insert(const SeenBeam& beam, const Heights& counted, Utime now);

  std::vector<Hit> hits_;      ///< a torus of cells of 6 cm
  std::vector<Place> places_;  ///< one of cells of 12 cm
};

}  // namespace marco::drivers
