#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/pose2.hpp"
#include "common/round_wall.hpp"
#include "slam/line_slam/circles/observed_circle.hpp"
#include "slam/line_slam/ekf/circle_evidence.hpp"
#include "slam/line_slam/ekf/ekf_state.hpp"
#include "slam/line_slam/ekf/wall_filter_options.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

/// A circle of the map, except its part of the state (x, y, radius, one unused).
struct MapCircle {
  int64_t id = 0;
  int block = 0;  ///< not stored: given out again by restore()
  int64_t times_seen = 0;
  bool from_inside = false;
  double advantage = 0.0;  ///< over lines, of all scans that saw it
  SeenArc arc;

  template <class Visitor>
  void visit(Visitor& v) {
    v("id", id);
    v("times_seen", times_seen);
    v("from_inside", from_inside);
    v("advantage", advantage);
    arc.visit(v);
  }
};

/// What looks round, but could still be something else: not yet in the state.
struct CircleCandidate {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< x, y, radius, world frame
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  bool from_inside = false;
  int64_t times_seen = 0;
  int64_t times_looked = 0;  ///< steps since it was first seen
  double advantage = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("mean", mean);
    v("covariance", covariance);
    v("from_inside", from_inside);
    v("times_seen", times_seen);
    v("times_looked", times_looked);
    v("advantage", advantage);
  }
};

/// Posts and curved walls in the filter of robot and walls, with the same state, linearization and
/// evidence. A circle is taken into the state when scans together prefer it to lines. Steps of one
/// scan, in this order: associate, correct, extend, add, join, judge. Not thread-safe.
class CircleMap {
 public:
  explicit CircleMap(const WallFilterOptions& options);

  static constexpr int kNew = -1, kUnclear = -2;

  std::size_t size() const { return circles_.size(); }
  const MapCircle& circle(std::size_t index) const { return circles_[index]; }
  const std::vector<CircleCandidate>& candidates() const { return candidates_; }
  std::vector<int> blocks() const;

  /// @returns per observed circle an index, kNew, or kUnclear where two would do.
  std::vector<int> associate(const EkfState& state,
                             const std::vector<ObservedCircle>& observed) const;
  /// Leaves finish_corrections() to the caller.
  void correct(EkfState& state,
               const std::vector<ObservedCircle>& observed,
               const std::vector<int>& matches);
  /// Arcs grow by what is seen of them.
  void extend(const EkfState& state,
              const std::vector<ObservedCircle>& observed,
              const std::vector<int>& matches);
  /// Takes new ones as candidates, and those into the state that have proved round.
  void add_new(EkfState& state,
               const std::vector<ObservedCircle>& observed,
               const std::vector<int>& matches);
  /// Joins circles that are one: concentric and of equal radius, as far as is known.
  void join_concentric(EkfState& state);
  /// Raises and lowers the evidence by the rays of a scan; what fell below the limit is removed.
  void judge(EkfState& state, const ScanInRobot& scan, double pose_margin_m);

  /// Evidence starts again; see WallFilter::judge_again.
  void forget_evidence();
  void vote(const EkfState& state, const ScanInRobot& scan, const Pose2& world_from_robot);

  /// Whether a wall is nothing but a chord of a circle.
  bool holds(const EkfState& state, const Eigen::Vector4d& wall) const;
  RoundWalls plan(const EkfState& state, int64_t min_times_seen) const;

  struct Stored {
    std::vector<MapCircle> circles;
    std::vector<CircleCandidate> candidates;
    int64_t next_id = 1;
  };
  Stored store() const { return {circles_, candidates_, next_id_}; }
  /// Puts stored circles in the place of all, with new blocks whose values are not set yet.
  /// @throws std::invalid_argument for an arc without extent.
  void restore(EkfState& state, const Stored& stored);

 private:
  SparseRows measurement(const EkfState& state,
                         const ObservedCircle& observed,
                         std::size_t index) const;
  void add(EkfState& state, const ObservedCircle& observed, const CircleCandidate& proved);
  void remove(EkfState& state, std::size_t index);
  /// Whether rays may judge it. @param circle  x, y, radius.
  bool is_in_reach(const Eigen::Vector3d& circle, const Pose2& world_from_robot) const;
  bool are_one(const EkfState& state, std::size_t a, std::size_t b) const;
  void join(EkfState& state, std::size_t a, std::size_t b);

  WallFilterOptions options_;
  double gate_;  ///< of three values
  std::vector<MapCircle> circles_;
  std::vector<CircleCandidate> candidates_;
  int64_t next_id_ = 1;
};

}  // namespace marco::slam
