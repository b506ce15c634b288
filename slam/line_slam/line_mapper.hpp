#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/trajectory.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/back_end/graph/pose_graph.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/grid/occupancy_grid.hpp"
#include "slam/line_slam/line_slam.hpp"
#include "slam/mapper2d.hpp"
#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/oriented_points.hpp"
#include "slam/matching/surfel_matcher.hpp"
#include "slam/slam_state.hpp"

namespace marco::slam {

/// Of the filter's path it is not known how far it drifts: no place is less likely for that.
inline LoopCloserOptions wherever_they_fit() {
  LoopCloserOptions options;
  options.unlikely_penalty = 0.0;
  return options;
}

struct LineMapperOptions {
  LineSlamOptions lines;
  KeyframeOptions keyframes;
  bool close_loops = true;        ///< by the pose graph, where the filter alone would not
  double trusted_shift_m = 0.30;  ///< a loop that contradicts the filter by more is not its noise:
  double trusted_turn_deg = 3.0;  ///< ... the filter is too sure, and the graph is asked
  double edge_sigma_m = 0.008;    ///< added to what the filter says of the way between keyframes
  double edge_sigma_deg = 0.10;
  double replay_sigma_m = 0.02;  ///< of the graph's path when the filter is replayed along it
  double replay_sigma_deg = 0.5;
  NormalOptions normals;
  CorrelativeMatcherOptions coarse;
  SurfelMatcherOptions fine;
  LoopCloserOptions loops = wherever_they_fit();
  PoseGraphOptions graph;
  OccupancyGridOptions grid;

  template <class Visitor>
  void visit(Visitor& v) {
    lines.visit(v);
    v("close_loops", close_loops,
      "Close loops by a pose graph where the filter alone would not. Off to see the filter by "
      "itself.");
  }
};

/// The line SLAM with loop closure: keyframes form a pose graph, whose edges are the motions that
/// the filter measured between them. A revisit is closed by the filter's own joint data association
/// where its covariance allows that. Where it does not (a loop found by scan matching contradicts
/// an overconfident filter) the graph is optimized and the filter replayed along its path. A loop
/// that contradicts the rest of the graph changes nothing.
///
/// Deterministic; not thread-safe. Grows by about 30 kB a keyframe.
class LineMapper : public Mapper2d {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  explicit LineMapper(const LineMapperOptions& options, const Pose2& world_from_robot = {});

  /// As LineSlam::process. `trajectory_changed` is set when older poses moved.
  LineSlamUpdate process(const ScanInRobot& scan,
                         Utime utime,
                         const std::optional<Pose2>& robot_motion,
                         MapUse use = MapUse::draw,
                         LineSlamJournal* journal = nullptr);

  /// As LineSlam::carry: a pose for a scan that is not looked at.
  LineSlamUpdate carry(Utime utime, const Pose2& robot_motion);

  /// Optimizes the graph robustly and lays the walls along its path. More scans may follow.
  void finish();

  Pose2 world_from_robot() const { return slam_.world_from_robot(); }
  Walls plan() { return slam_.plan(); }
  const WallFilter& filter() const { return slam_.filter(); }

  /// One pose a scan processed or carried, in order, by the newest optimization.
  Trajectory trajectory() const;
  std::vector<std::optional<Pose2>> scan_poses() const override;
  Trajectory key_trajectory() const override;
  OccupancyGrid grid() const override;
  const std::vector<Loop>& loops() const override { return loops_; }
  const std::vector<Keyframe>& keys() const override { return keys_; }
  std::size_t key_count() const { return keys_.size(); }
  int replays() const { return replays_; }  ///< how often the filter was too sure
  int64_t revision() const override { return revision_; }

  /// Everything it knows; restored, it continues as if it had never stopped.
  struct Stored {
    LineSlam::Stored slam;
    std::vector<Keyframe> keys;
    std::vector<ScanInRobot> key_beams;  ///< one a keyframe
    std::vector<PoseGraphEdge> edges;
    std::vector<Loop> loops;  ///< one a loop edge, in their order
    std::vector<ScanPose> scans;
    double last_search_path_m = 0.0;
    double closed_path_m = 0.0;
    int32_t replays = 0;
    int64_t revision = 0;
  };
  Stored store();
  /// @throws std::invalid_argument naming what contradicts itself; nothing has changed then.
  void restore(const Stored& stored);

 private:
  bool key_is_due() const;
  void add_key(const ScanInRobot& scan, Utime utime);
  void note_pose(Utime utime);
  bool close_loops();
  void replay();

  LineMapperOptions options_;
  LineSlam slam_;
  LoopCloser loop_closer_;
  PoseGraph graph_;
  std::vector<Keyframe> keys_;
  std::vector<ScanInRobot> key_beams_;
  std::vector<ScanPose> scans_;
  std::vector<Loop> loops_;
  double last_search_path_m_ = 0.0;
  double closed_path_m_ = 0.0;
  int replays_ = 0;
  int64_t revision_ = 0;
};

}  // namespace marco::slam
