#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/free_space.hpp"
#include "plan/room_raster.hpp"

namespace marco::plan {

/// A line along which a room's outline runs. The room lies on the left of its direction.
struct OutlineLine {
  Eigen::Vector2d point, way;
  double along(const Eigen::Vector2d& at) const { return way.dot(at - point); }
  Eigen::Vector2d foot(const Eigen::Vector2d& at) const { return point + way * along(at); }
};

/// The circle of a curved wall, along which an outline runs.
struct OutlineCircle {
  Eigen::Vector2d centre;
  double radius_m;
  bool from_inside;
  Eigen::Vector2d foot(const Eigen::Vector2d& at) const {
    return centre + radius_m * (at - centre).normalized();
  }
  /// Towards the room.
  double off_m(const Eigen::Vector2d& at) const {
    const double beyond_m = (at - centre).norm() - radius_m;
    return from_inside ? -beyond_m : beyond_m;
  }
  /// From one point to another, the way that the outline runs: 0 to 2 pi.
  double turn_rad(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
};

/// Where two lines cross; nothing where they are nearly parallel.
std::optional<Eigen::Vector2d> crossing(const OutlineLine& a, const OutlineLine& b);

/// How far a simplified outline may lie from the steps that it is made of.
inline constexpr double kOutlineToleranceM = 0.12;

/// Part of a room's outline along one face or opening, or along none.
struct OutlineRun {
  EdgeKind kind = EdgeKind::unseen;
  int index = -1;  ///< of the face or of the opening
  std::vector<Eigen::Vector2d> steps;
  bool furnished = false;  ///< furniture was taken from here

  double length_m() const { return FreeSpace::kCellM * static_cast<double>(steps.size()); }
  bool is_line() const { return kind != EdgeKind::unseen; }
  bool same(const OutlineRun& other) const { return kind == other.kind && index == other.index; }
};

/// A room's outline as runs along the plan's faces and openings. What stands at its walls is taken
/// off. What it is made of outlives it. Not thread-safe.
class OutlineRuns {
 public:
  OutlineRuns(const std::vector<OutlineStep>& outline,
              const FloorPlan& plan,
              const RoomRaster& raster,
              const FreeSpace& space);

  /// Takes off what stands at a wall or in a corner, closes as a box, and hides what is behind it:
  /// up to 1 m deep and 4 m long, as kitchens are. The wall continues behind it.
  void take_furniture(std::vector<PlanObject>& furniture);

  std::vector<OutlineRun>& runs() { return runs_; }
  const std::vector<OutlineRun>& runs() const { return runs_; }
  /// @param run  one that is_line()
  OutlineLine line_of(const OutlineRun& run) const;
  /// The circle that both runs are chords of, if there is one.
  std::optional<OutlineCircle> common_circle(const OutlineRun& one, const OutlineRun& other) const;
  /// Whether hardly a beam passed through the way between both points.
  bool hidden_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
  /// Likewise along a circle.
  bool hidden_along(const OutlineCircle& circle,
                    const Eigen::Vector2d& from,
                    const Eigen::Vector2d& to) const;

 private:
  enum class Place { wall, corner };
  OutlineRun label(const OutlineStep& step) const;
  void add(OutlineRun run, const Eigen::Vector2d& at);
  void merge_neighbours();
  void clean();
  bool continues(std::size_t at) const;
  bool take_one(Place place, std::vector<PlanObject>& furniture);
  bool stands_at(Place place,
                 const OutlineRun& one,
                 const std::vector<Eigen::Vector2d>& steps,
                 const OutlineRun& next) const;
  bool stands_at_curve(const OutlineCircle& circle,
                       const OutlineRun& one,
                       const std::vector<Eigen::Vector2d>& steps,
                       const OutlineRun& next) const;

  const std::vector<WallFace>& faces_;
  const RoundWalls& arcs_;
  const std::vector<PlanOpening>& openings_;
  const RoomRaster& raster_;
  const FreeSpace& space_;
  std::vector<OutlineRun> runs_;
};

}  // namespace marco::plan
