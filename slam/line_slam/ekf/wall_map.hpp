#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/pose2.hpp"
#include "slam/line_slam/ekf/ekf_state.hpp"
#include "slam/line_slam/ekf/similar.hpp"
#include "slam/line_slam/ekf/wall_evidence.hpp"
#include "slam/line_slam/ekf/wall_filter_options.hpp"
#include "slam/line_slam/ekf/wall_observation.hpp"
#include "slam/line_slam/lines/observed_wall.hpp"

namespace marco::slam {

/// A wall of the map, except its part of the state.
struct MapWall {
  int64_t id = 0;
  int block = 0;  ///< not stored: given out again by restore()
  int64_t times_seen = 0;
  bool start_seen = false;
  bool end_seen = false;
  WallEvidence evidence;

  template <class Visitor>
  void visit(Visitor& v) {
    v("id", id);
    v("times_seen", times_seen);
    v("start_seen", start_seen);
    v("end_seen", end_seen);
    evidence.visit(v);
  }
};

/// Robot and walls: the filter's state, and what is known of each wall besides. Walls are named by
/// index; removing one gives its index to the last wall. Not thread-safe.
class WallMap {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  WallMap(const WallFilterOptions& options, const Pose2& world_from_robot);

  const WallFilterOptions& options() const { return options_; }
  EkfState& state() { return state_; }
  const EkfState& state() const { return state_; }

  Pose2 world_from_robot() const;
  Eigen::Matrix3d robot_covariance() const;
  std::size_t size() const { return walls_.size(); }
  MapWall& wall(std::size_t index) { return walls_[index]; }
  const MapWall& wall(std::size_t index) const { return walls_[index]; }
  const std::vector<MapWall>& walls() const { return walls_; }
  int64_t next_id() const { return next_id_; }
  /// x1 y1 x2 y2.
  Eigen::Vector4d mean(std::size_t index) const { return state_.mean(walls_[index].block); }
  Segment segment(std::size_t index) const;
  /// Blocks of all walls, in order of index.
  std::vector<int> blocks() const;
  Segment seen_in_world(const ObservedWall& observed) const;

  /// The measurement of a map wall by an observed one, with the options' error floors.
  SparseRows measurement(const ObservedWall& observed, std::size_t index, MatchedEnds ends) const;
  /// Largest distance along the wall at which two ends may be the same end.
  double end_limit_m(const ObservedWall& observed, std::size_t index) const;
  /// 5.2.5: ends that are seen as ends in both and lie close together.
  MatchedEnds matched_ends(const ObservedWall& observed, std::size_t index) const;

  /// State augmentation (5.3.2, 5.47-5.53). @returns index of the new wall.
  std::size_t add(const ObservedWall& observed);
  /// Marginalizes a wall out.
  void remove(std::size_t index);

  /// Puts stored walls in the place of all, with new blocks whose values are not set yet.
  void restore(const std::vector<MapWall>& walls, int64_t next_id);

 private:
  ObservedWall with_floors(const ObservedWall& observed) const;

  WallFilterOptions options_;
  EkfState state_;
  std::vector<MapWall> walls_;
  int64_t next_id_ = 1;
};

}  // namespace marco::slam
