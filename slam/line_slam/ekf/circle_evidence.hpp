#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/pose2.hpp"
#include "common/round_wall.hpp"
#include "slam/line_slam/ekf/wall_evidence.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

/// A circle up to this radius is a post: a thing of its own, which is drawn whole.
inline constexpr double kLargestPostM = 0.5;

/// What was seen of a circle, and the evidence along it.
struct SeenArc {
  double from_rad = 0.0;  ///< world frame, from the centre
  double span_rad = 0.0;  ///< counter-clockwise; 2 pi at most
  double scale_m = 1.0;   ///< of the evidence, per radian: the radius when it was first seen
  WallEvidence evidence;

  SeenArc() = default;
  SeenArc(const WallEvidenceOptions& options, double from, double span, double radius_m);

  /// The smallest arc that holds both.
  void grow(double from, double span);
  /// Takes over another's extent and evidence.
  void merge(const SeenArc& other);
  /// Each ray of a scan votes on the place where it meets the circle, as it does on walls.
  /// @param circle  x, y, radius, world frame. @param pose_margin_m  added to the margin of a hit.
  void vote_by_rays(const ScanInRobot& scan,
                    const Pose2& world_from_robot,
                    const Eigen::Vector3d& circle,
                    bool from_inside,
                    double pose_margin_m);

  struct Run {
    double from_rad;
    double span_rad;
  };
  /// What of it stands now: a post whole, of a wall the pieces.
  std::vector<Run> standing(double radius_m, const WallEvidenceOptions& options) const;

  /// What is stored.
  template <class Visitor>
  void visit(Visitor& v) {
    v("from_rad", from_rad);
    v("span_rad", span_rad);
    v("scale_m", scale_m);
    evidence.visit(v);
  }
};

}  // namespace marco::slam
