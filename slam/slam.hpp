#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/input/deskew.hpp"
#include "common/pose_estimate.hpp"
#include "common/trajectory.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/back_end/back_end.hpp"
#include "slam/back_end/edited_loops.hpp"
#include "slam/front_end/drift_filter.hpp"
#include "slam/front_end/match_gate.hpp"
#include "slam/front_end/motion_model.hpp"
#include "slam/front_end/pose_with_covariance.hpp"
#include "slam/front_end/range_noise.hpp"
#include "slam/front_end/scan_matcher.hpp"
#include "slam/front_end/unknown_scale.hpp"
#include "slam/front_end/zero_velocity_update.hpp"
#include "slam/grid/occupancy_grid.hpp"
#include "slam/map/keyframe.hpp"
#include "slam/map/keyframe_culling.hpp"
#include "slam/map/local_map.hpp"
#include "slam/map/scan_path.hpp"
#include "slam/slam_state.hpp"

namespace marco::slam {

struct MatchedScan;  // straightening.hpp
class Straightening;

struct SlamOptions {
  KeyframeOptions keyframes;
  LocalMapOptions local_map;
  MatchGateOptions gates;
  CullingOptions culling;
  MotionOptions motion;
  NormalOptions normals;
  SurfelMatcherOptions fine;
  CorrelativeMatcherOptions coarse;
  LoopCloserOptions loops;
  PoseGraphOptions graph;
  JointRefinementOptions refinement;
  OccupancyGridOptions grid;

  template <class Visitor>
  void visit(Visitor& v) {
    visit_without_culling(v);
    v("culling", culling);
  }
  /// Settings of a mapper that keeps all its keyframes.
  template <class Visitor>
  void visit_without_culling(Visitor& v) {
    keyframes.visit(v);
    local_map.visit(v);
    gates.visit(v);
    v("motion", motion);
    v("normals", normals);
    v("fine", fine);
    v("coarse", coarse);
    v("loops", loops);
    v("graph", graph);
    v("grid", grid);
  }
};

/// A scan and what else is known at its time.
struct SlamInput {
  DeskewedScan scan;
  MotionInput motion;
  /// The scan was deskewed by odometry; else its match straightens it, see straightening.hpp.
  bool deskewed_by_odometry = false;
  /// Alternative times of the beams, one per beam; mostly none.
  std::vector<std::vector<float>> rival_times_s;
  bool level = true;     ///< false: taken with the laser tilted; the pose is carried on without it
  bool may_draw = true;  ///< false: gets a pose, but never becomes part of the map
};

/// Deskews a scan by the robot's velocity during it, and projects it into the robot's frame.
SlamInput slam_input(const SynchronizedScan& scan, const ScanVelocity& velocity);

struct SlamUpdate {
  using Status = PoseEstimate::Status;

  Pose2 world_from_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), world frame
  Status status = Status::predicted;
  double overlap = 0.0;            ///< part of the points that found a wall
  std::vector<double> misfits_m2;  ///< see MatchedScan
  bool became_key = false;
  bool covered = false;             ///< something covered the laser: the scan was not used
  bool trajectory_changed = false;  ///< older poses moved: a loop was closed
};

/// The pipeline of scan SLAM: predict, match, gate, keyframe, update; loop closures in parallel.
///
/// The world frame is the first scan's robot frame. Deterministic: a pure function of its inputs.
/// Not thread-safe. Redundant keyframes are culled, so that the map grows with the area; the path
/// grows with time: 40 bytes a scan, and as many for each keyframe ever made (neither after
/// keep_short_path()).
class Slam {
 public:
  /// @throws std::invalid_argument for an option outside its limits.
  explicit Slam(const SlamOptions& options = {});

  SlamUpdate process(const SlamInput& input);

  /// Optimizes with robust loops and refines all keyframes jointly. More scans may follow.
  JointRefinementResult finish();

  /// One pose for each scan processed, in order, by the newest optimization; fewer of a short path.
  Trajectory trajectory() const { return path_.scans(keyframes_.keys); }
  /// At each keyframe ever made, the merged ones included; of a short path fewer of the latter, the
  /// fewer the longer ago.
  Trajectory key_trajectory() const { return path_.keyframes(keyframes_.keys); }
  /// Grows whenever older poses changed.
  int64_t revision() const { return revision_; }
  const std::vector<Loop>& loops() const { return back_end_.loops(); }
  /// Of the pose graph, those of loops included.
  const std::vector<PoseGraphEdge>& edges() const { return back_end_.state().edges; }
  const std::vector<Keyframe>& keys() const { return keyframes_.keys; }
  std::size_t key_count() const { return keyframes_.keys.size(); }
  /// The next scan's motion input has nothing to do with the last one's.
  void forget_motion() { motion_ = MotionModel(options_.motion); }
  /// See MotionModel.
  ScanVelocity velocity_during(const std::optional<Pose2>& odometry_step, double duration_s) const {
    return motion_.velocity_during(
        odometry_step ? std::optional(drift_.state().bias.corrected(*odometry_step, false))
                      : std::nullopt,
        duration_s);
  }

  /// The occupancy grid of all keyframes at their newest poses.
  OccupancyGrid grid() const;

  /// From here on loops are forbidden and added as these say; the rest of them is the caller's.
  /// Not where loops are searched by the caller.
  void set_edits(const MapEdits& edits);
  /// Adds and takes away loops of the map as it is; finish() makes use of it. Other edits are
  /// ignored.
  void apply(const MapEdits& edits);

  /// From here on loops are searched, and the graph is optimized, by the caller: a scan's cost no
  /// longer depends on the map's size. After each scan call take_loop_work(); run what it returns,
  /// on any thread; then accept() it.
  void defer_loop_work() { back_end_.defer_work(); }
  /// One at a time: nothing until the last one was accepted.
  std::optional<LoopWork> take_loop_work() { return back_end_.take_work(); }
  /// Keyframes that came meanwhile follow the newest one that was there. Ignores work taken before
  /// a restore or reset. @returns whether older poses moved.
  bool accept(const LoopWork& work);

  /// From here on the path follows the map, not the time: of scans taken nearer to the last kept
  /// one than `every_m` (and turned by less than as many radians) no pose is kept, nor of those
  /// relative to a merged keyframe. Those before index `first` stay. Of merged keyframes, three
  /// times as many poses are kept as there are keyframes. The poses of new scans do not change.
  /// @throws std::invalid_argument below 0.
  void keep_short_path(double every_m, std::size_t first = 0) { path_.keep_short(every_m, first); }

  /// Everything it knows, as a value; restored, it continues as if it had never stopped.
  SlamState state() const;
  /// @throws std::invalid_argument as check().
  void restore(const SlamState& state);
  /// Appends another session, recorded in the same building, and continues from its end: its
  /// keyframes join this map, loops between both are searched, and the graph is optimized.
  /// @param edge  a measured pose of its keyframe `to` (counted in `session`) seen from this map's
  /// keyframe `from`. @throws std::invalid_argument as check(), or for keyframes that are not
  /// there.
  void join(const SlamState& session, const PoseGraphEdge& edge);

 private:
  /// What is known of a scan before it is matched.
  struct Prediction {
    MotionInput motion;
    MotionGuess guess;
    CarriedPose carried;
    PosePrior prior;              ///< against the local map
    PoseWithCovariance in_world;  ///< that of `estimate_`, carried on
    UnknownScale scale;
    bool covered = false;  ///< something covered the laser
    bool refines = false;  ///< it has few returns: they refine the odometry's pose
    bool is_matched = false;
  };
  Prediction predict(const SlamInput& input);
  MatchedScan matched_scan(const SlamInput& input, Prediction& predicted);
  bool refuse(ScanMatch& match, const Prediction& predicted);
  /// @returns the covariance of an edge of the graph from the newest keyframe, world axes
  Eigen::Matrix3d move(const MatchedScan& matched, const Prediction& predicted);
  static PosePrior prior_of(const PoseWithCovariance& predicted);
  bool becomes_keyframe(const SlamInput& input) const;
  /// Oriented and matched as it is.
  MatchedScan matched_as_is(DeskewedScan scan,
                            const PosePrior& prior,
                            MotionGuess::Source source,
                            ScanMatcher::Search search = ScanMatcher::Search::everywhere);
  /// Matched against the local map, and straightened.
  MatchedScan matched_scan(const SlamInput& input,
                           const PosePrior& prior,
                           MotionGuess::Source source);
  /// Odometry may have jumped beyond every search window. The scan decides between the match and
  /// one at the constant-velocity prediction.
  void try_where_velocity_says(const MotionInput& input, MatchedScan& best);
  MatchedScan best_bent(MatchedScan best,
                        const DeskewedScan& predicted,
                        const Straightening& straightening,
                        const PosePrior& prior,
                        MotionGuess::Source source);
  SlamUpdate note_scan(const SlamInput& input, const PoseWithCovariance& estimate, bool matched);
  /// By the match and the prediction; of a robot that stands, by all matches from its place.
  /// @param information  of the prediction
  PoseWithCovariance estimate_from(const ScanMatch& match,
                                   const Eigen::Matrix3d& information,
                                   bool stands);
  void add_keyframe(const SlamInput& input,
                    const OrientedPoints& points,
                    const Eigen::Matrix3d& edge_covariance);
  bool search_loops();
  bool add_edited_loops();
  /// A few keyframes whose loops were examined are merged into older ones.
  void cull_keyframes();
  void merge_keyframe(int key, const MergedKeyframe& merged);
  void move_keyframes(const std::vector<Pose2>& world_from_keys);

  SlamOptions options_;
  ScanMatcher matcher_;
  RangeNoise noise_;
  MotionModel motion_;
  DriftFilter drift_;
  PoseWithCovariance estimate_;  ///< at the last scan that was matched, or carried without odometry
  UnknownScale scale_;           ///< there
  std::optional<ZeroVelocityUpdate> standing_;  ///< nothing while the robot moves
  bool covered_ = false;                        ///< the laser was, in the last scan with returns
  MatchGate gate_;
  KeyframeSet keyframes_;
  ScanPath path_;
  LocalMap local_map_;
  KeyframeCulling culling_;
  BackEnd back_end_;
  EditedLoops edited_loops_;
  int64_t revision_ = 0;
};

}  // namespace marco::slam
