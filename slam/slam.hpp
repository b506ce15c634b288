#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/trajectory.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/back_end/graph/joint_refinement.hpp"
#include "slam/back_end/graph/pose_graph.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/back_end/loop_work.hpp"
#include "slam/front_end/motion_model.hpp"
#include "slam/front_end/zero_velocity_update.hpp"
#include "slam/grid/occupancy_grid.hpp"
#include "slam/input/deskew.hpp"
#include "slam/map/keyframe_culling.hpp"
#include "slam/map/slam_state.hpp"
#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/oriented_points.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace marco::slam {

struct SlamOptions {
  double key_distance_m = 0.30;  ///< a keyframe is kept after this move ...
  double key_turn_deg = 15.0;    ///< ... or this turn of the robot or of a panning laser
  int window_keyframes = 15;     ///< the local map is made of this many last keyframes ...
  int window_slack = 5;        ///< ... and up to so many more: it is made anew when these are full
  int min_points = 20;         ///< a scan with fewer returns is not matched
  double sure_overlap = 0.8;   ///< below it odometry may lie: the scan is matched without it, too
  double good_overlap = 0.5;   ///< below it the search is widened
  double poor_overlap = 0.25;  ///< below it the match is not used
  ThinningOptions thinning;
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
    v("key_distance_m", key_distance_m, kPositive);
    v("key_turn_deg", key_turn_deg, kPositive);
    v("window_keyframes", window_keyframes, Limits{1, 1000});
    v("window_slack", window_slack, Limits{0, 1000});
    v("min_points", min_points, Limits{3, 100000});
    v("sure_overlap", sure_overlap, Limits{0.0, 1.0});
    v("good_overlap", good_overlap, Limits{0.0, 1.0});
    v("poor_overlap", poor_overlap, Limits{0.0, 1.0});
    v("thinning", thinning);
    v("motion", motion);
    v("normals", normals);
    v("fine", fine);
    v("coarse", coarse);
    v("loops", loops);
    v("graph", graph);
    v("refinement", refinement);
    v("grid", grid);
  }
};

/// A scan and what else is known at its time.
struct SlamInput {
  DeskewedScan scan;
  MotionInput motion;
  bool level = true;     ///< false: taken with the laser tilted; the pose is carried on without it
  bool may_draw = true;  ///< false: gets a pose, but never becomes part of the map
};

struct SlamUpdate {
  enum class Status {
    matched,
    carried,  ///< no usable match: by odometry or the last motion
    lost      ///< no pose in the map is known
  };

  Pose2 world_from_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), world frame
  Status status = Status::carried;
  double overlap = 0.0;  ///< part of the points that found a wall
  bool became_key = false;
  bool trajectory_changed = false;  ///< older poses moved: a loop was closed
};

/// The pipeline: predict, match against the local map, keep keyframes, close loops, optimize.
///
/// The world frame is the first scan's robot frame. Deterministic: a pure function of its inputs.
/// Not thread-safe. Keyframes of a place seen often enough become one (keyframe_culling.hpp), so
/// that what is kept grows with the area; the path grows with time: 40 bytes a scan, and as many
/// for each keyframe that ever was (neither after keep_short_path()).
class Slam {
 public:
  /// @throws std::invalid_argument for an option outside its limits.
  explicit Slam(const SlamOptions& options = {});

  SlamUpdate process(const SlamInput& input);

  /// Optimizes with robust loops, refines all keyframes jointly and places the scans between them
  /// again. More scans may follow.
  void finish();

  /// One pose a processed scan, in order, by the newest optimization; fewer of a short path.
  Trajectory trajectory() const;
  /// At each keyframe that was made, also those that have become one with an older; of a short path
  /// fewer of the latter, the fewer the longer ago.
  Trajectory key_trajectory() const;
  /// Grows whenever older poses changed.
  int64_t revision() const { return revision_; }
  const std::vector<Loop>& loops() const { return loops_; }
  const std::vector<Keyframe>& keys() const { return keys_; }
  std::size_t key_count() const { return keys_.size(); }
  const JointRefinementResult& refinement() const { return refined_; }
  /// The next scan's motion input has nothing to do with the last one's.
  void forget_motion() { motion_ = MotionModel(options_.motion); }
  Velocity2 velocity() const { return motion_.velocity(); }

  /// The occupancy grid of all keyframes at their newest poses.
  OccupancyGrid grid() const;

  /// Loops are looked for, and the graph is optimized, when somebody asks for it: a scan's cost no
  /// longer depends on the map's size. After each scan ask take_loop_work(); run what it gives, on
  /// any thread; then accept() it. Without this each scan waits for its own.
  void defer_loop_work() { deferred_ = true; }
  /// One at a time: nothing until the last one was accepted.
  std::optional<LoopWork> take_loop_work();
  /// Keyframes that came meanwhile follow the newest one that was there. Work taken before a
  /// restore or reset is left aside.
  /// @returns whether older poses moved.
  bool accept(const LoopWork& work);

  /// From here on the path follows the map, not the time: of scans taken nearer to the last kept
  /// one than `every_m` (and turned by less than as many radians) no pose is kept, nor of those
  /// that hang on a keyframe that becomes one with an older. Those before index `first` stay. Of
  /// keyframes that became one, as many poses are kept as there are keyframes, times three.
  /// What poses come of the scans does not change. @throws std::invalid_argument below 0.
  void keep_short_path(double every_m, std::size_t first = 0);

  /// Everything it knows, as a value; what restore() takes goes on as if nothing had been.
  SlamState state() const;
  /// @throws std::invalid_argument as check().
  void restore(const SlamState& state);
  /// Goes on from the end of another session, recorded elsewhere in the same building: its key
  /// scans join this map, loops between both are searched, and the graph is optimized.
  /// @param tie  a measured pose of its keyframe `to` (counted in `session`) seen from this map's
  /// keyframe `from`. @throws std::invalid_argument as check(), or for keyframes that are not
  /// there.
  void join(const SlamState& session, const PoseGraphEdge& tie);

 private:
  struct Match {
    Pose2 world_from_robot;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    double overlap = 0.0;
    bool usable = false;
  };

  SlamUpdate note_scan(Utime utime,
                       const Pose2& world_from_robot,
                       const Eigen::Matrix3d& covariance);
  PosePrior prior_of(const MotionGuess& guess) const;
  Match match(const OrientedPoints& points, const MotionGuess& guess, const PosePrior& prior);
  Match match_widely(const OrientedPoints& points,
                     const SearchWindow& window,
                     const PosePrior& prior);
  /// Of the last keyframes, as they lie now.
  const LikelihoodPyramid& likelihood_here();
  /// Whether the match, now laid aside, puts the robot where it cannot have driven.
  bool doubt_leap(Match& found, const PosePrior& prior, Utime utime);
  /// Of a robot that stands: the match is one more look from the same place.
  void look_again(Match& match, Eigen::Matrix3d& covariance);
  bool key_is_due(const DeskewedScan& scan, const Pose2& world_from_robot) const;
  void add_key(const SlamInput& input, const OrientedPoints& points, const Match& match);
  bool look_for_loops();
  /// First keyframe that the local map is made of, counted in all that ever were: a function of
  /// their number alone.
  int first_local() const;
  /// The same as an index into keys_.
  int first_local_key() const { return std::max(0, first_local() - merged_keys_); }
  bool thinning_is_due() const;
  /// Of the keyframes whose loops were doubted and held, a few become one with older ones.
  void thin_keys();
  void forget_wrong_loops(const LoopWork& work);
  void remake_graph(const std::vector<PoseGraphEdge>& edges);
  bool merge_into_older(int key);
  bool is_closed_around(double path_m) const;
  void rehang_scans(int key, const MergedKeyframe& merged);
  bool is_worth_keeping(const ScanPose& scan) const;
  void forget_scans_of(int key);
  /// Of a short path: when it has grown beyond what the map's size allows.
  void thin_trail();
  void extend_local_map();
  void rebuild_local_map();
  void rebuild_local_map(const Eigen::Vector2d& centre_m);
  void find_loops_across(int key, int first_key, std::vector<Keyframe>& nearby);
  static OrientedScan only_oriented(const OrientedPoints& points);
  void move_keys(const std::vector<Pose2>& world_from_keys);

  SlamOptions options_;
  SurfelMatcher matcher_;
  CorrelativeMatcher coarse_;
  LoopCloser loop_closer_;
  MotionModel motion_;
  std::optional<Standing> standing_;  ///< nothing while the robot moves
  PoseGraph graph_;
  std::vector<Keyframe> keys_;
  std::vector<ScanPose> scans_;
  std::vector<ScanPose> trail_;  ///< as SlamState::trail
  std::vector<Loop> loops_;
  std::optional<SurfelPyramid> local_map_;
  int local_map_first_ = 0;                      ///< as first_local()
  std::optional<LikelihoodPyramid> likelihood_;  ///< see likelihood_here(); until keyframes change
  int looked_at_ = 0;    ///< keyframes before this one have been looked at by thin_keys() ...
  int thin_until_ = 0;   ///< ... and before this one, none needs to be any more
  int kept_keys_ = 0;    ///< there were when it was last through
  int merged_keys_ = 0;  ///< so many have become one with an older
  std::optional<Utime> leaps_since_;  ///< as SlamState::leaps_since
  int unmatched_ = 0;                 ///< as SlamState::unmatched
  Pose2 world_from_robot_;            ///< at the last scan that was looked at
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
  double last_search_path_m_ = 0.0;  ///< of the last look for loops
  double closed_path_m_ = 0.0;       ///< when a loop was last closed
  std::vector<double> closings_m_;   ///< the same of the last loops
  JointRefinementResult refined_;
  int64_t revision_ = 0;
  std::optional<double> path_every_m_;  ///< of a short path
  std::size_t short_path_from_ = 0;     ///< of scans_
  bool deferred_ = false;
  bool work_is_out_ = false;
  std::optional<LoopWork> work_;  ///< to be taken
};

}  // namespace marco::slam
