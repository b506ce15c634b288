#pragma once

#include <optional>
#include <vector>

#include "slam/line_slam/circles/circle_fit.hpp"
#include "slam/line_slam/circles/circle_sums.hpp"
#include "slam/line_slam/circles/observed_circle.hpp"
#include "slam/line_slam/lines/fitted_line.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

/// Posts, legs and columns of 2 cm to 50 cm radius, and curved walls up to 15 m, of one scan:
/// stretches of points that an algebraic circle passes, then fitted by rays (circle_fit.hpp), then
/// compared with a line and with a corner of two lines. Noise is the laser's, or what the scan
/// itself shows where that is more. Not thread-safe; keeps its memory from scan to scan.
class CircleExtractor {
 public:
  /// Circles in order of bearing. The reference is valid until the next call.
  /// @param max_range_m  farther points are not used
  const std::vector<ObservedCircle>& extract(const ScanInRobot& scan, double max_range_m);

 private:
  static constexpr double kSurfaceSigmaM = 0.002;  ///< roughness of real walls

  struct Point {
    Eigen::Vector2d at_m;  ///< from the sensor
    double range_m;
    int beam;
  };
  /// Points first..last.
  struct Stretch {
    int first, last;
    int size() const { return last - first + 1; }
  };

  void take_points(const ScanInRobot& scan, double max_range_m);
  double noise_of_points() const;
  bool is_cut_after(int point) const;
  RoughCircle rough(const Stretch& stretch) const;
  bool is_round(const Stretch& stretch) const;
  bool bends(const Stretch& stretch) const;
  void look_at_run(const Stretch& run);
  void try_stretch(Stretch stretch, const Stretch& run);
  std::optional<FittedCircle> start_of(const Stretch& stretch, const Stretch& run) const;
  std::vector<CircleRay> rays_of(const Stretch& stretch, const Stretch& run) const;
  void add_passed(std::vector<CircleRay>& rays, const Stretch& run, int step) const;
  /// Of a beam at an edge, any part of whose spot may have answered.
  double spot_sigma_rad() const;
  CircleRay ray_to(int point) const;
  Stretch reach_of(const FittedCircle& circle, Stretch stretch, const Stretch& run) const;
  double advantage_of(const FittedCircle& circle, const Stretch& stretch) const;
  void add(const FittedCircle& circle, const Stretch& stretch, const Stretch& run);

  const Point& point(int i) const { return points_[static_cast<std::size_t>(i)]; }

  const ScanInRobot* scan_ = nullptr;
  double sigma_m_ = 0.01;
  std::vector<Point> points_;
  std::vector<CircleSums> sums_;     ///< of all points before this one
  std::vector<LineSums> line_sums_;  ///< likewise
  std::vector<ObservedCircle> circles_;
};

}  // namespace marco::slam
