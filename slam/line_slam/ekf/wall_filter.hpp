#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "common/wall.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/line_slam/ekf/compressed_state.hpp"
#include "slam/line_slam/ekf/motion.hpp"
#include "slam/line_slam/ekf/similar.hpp"
#include "slam/line_slam/ekf/wall_evidence.hpp"
#include "slam/line_slam/ekf/wall_observation.hpp"
#include "slam/line_slam/lines/observed_wall.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

struct WallFilterOptions {
  MotionNoiseOptions motion;
  SimilarOptions similar;             ///< limits of `Similar`; widened by the pose's uncertainty
  std::string association = "joint";  ///< "joint" (Mahalanobis gates, JCBB) or "similar"
  double gate_probability = 0.99;     ///< of keeping a true pairing
  double end_distance_m = 0.10;       ///< d_l: nearer ends are the same end
  double max_end_distance_m = 0.5;    ///< ... however unsure the pose is
  double across_floor_m = 0.01;       ///< no wall is seen more exactly: it is not quite straight
  double direction_floor_rad = 0.003;
  double join_sigma_m = 0.01;   ///< how well the parts of one wall lie on one line
  double start_sigma_m = 1e-3;  ///< of the first pose (5.40); not 0
  double start_sigma_rad = 1e-3;
  int new_wall_points = 8;          ///< fewer do not start a wall of the map
  double new_wall_length_m = 0.80;  ///< nor do shorter ones
  double active_radius_m = 24.0;    ///< walls as near as this are in the active part
  double active_behind_m = 1.0;     ///< ... unless the robot is as far behind their line
  double active_margin_m = 2.0;     ///< more is made active at once, so that it lasts a while
  int max_dense_walls = 24;         ///< with fewer walls all are active
  int catch_up_tiles = 12;          ///< of the put-off covariance each scan, or ...
  double catch_up_part = 0.1;       ///< ... this part of all, whichever is more
  WallEvidenceOptions evidence;

  template <class Visitor>
  void visit(Visitor& v) {
    v("motion", motion);
    v("similar", similar);
    v("association", association);
    v("gate_probability", gate_probability, Limits{0.5, 0.999999});
    v("end_distance_m", end_distance_m, kPositive);
    v("max_end_distance_m", max_end_distance_m, kPositive);
    v("across_floor_m", across_floor_m, kNotNegative);
    v("direction_floor_rad", direction_floor_rad, kNotNegative);
    v("join_sigma_m", join_sigma_m, kPositive);
    v("start_sigma_m", start_sigma_m, kPositive);
    v("start_sigma_rad", start_sigma_rad, kPositive);
    v("new_wall_points", new_wall_points, Limits{3, 1000});
    v("new_wall_length_m", new_wall_length_m, kNotNegative);
    v("active_radius_m", active_radius_m, kPositive);
    v("active_behind_m", active_behind_m, kNotNegative);
    v("active_margin_m", active_margin_m, kNotNegative);
    v("max_dense_walls", max_dense_walls, Limits{0, 1e6});
    v("catch_up_tiles", catch_up_tiles, Limits{1, 1e6});
    v("catch_up_part", catch_up_part, Limits{0.0, 1.0});
    v("evidence", evidence);
  }
};

/// What became of one observed wall.
struct WallMatch {
  static constexpr int kNew = -1;      ///< like nothing in the map
  static constexpr int kUnclear = -2;  ///< like something, but it does not fit together: not used
  int wall = kNew;                     ///< index of the map's wall
  double distance2 = 0.0;              ///< squared Mahalanobis distance of the pairing (2 degrees)
};

/// A wall of the map, beside its part of the state.
struct MapWall {
  int64_t id = 0;
  int block = 0;
  int64_t times_seen = 0;
  bool start_seen = false;
  bool end_seen = false;
  WallEvidence evidence;
};

/// Thesis A's filter: robot and walls in one extended Kalman filter, with first-estimates Jacobians
/// (spec: a plain EKF grows too sure of its heading). Steps of one scan, in this order: predict,
/// focus, associate, correct, extend, add, join, judge. Not thread-safe.
class WallFilter {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  WallFilter(const WallFilterOptions& options, const Pose2& world_from_robot);

  Pose2 world_from_robot() const;
  Eigen::Matrix3d robot_covariance() const;
  std::size_t num_walls() const { return walls_.size(); }
  const MapWall& wall(std::size_t index) const { return walls_[index]; }
  Segment segment(std::size_t index) const;
  /// x1 y1 x2 y2.
  Eigen::Vector4d wall_mean(std::size_t index) const { return state_.mean(walls_[index].block); }

  /// (5.2-5.14) by odometry.
  void predict(const Pose2& robot_motion);
  /// The same for a move known otherwise. @param noise  V_r, world frame.
  void predict(const Pose2& robot_motion, const Eigen::Matrix3d& noise);

  /// Makes the walls around the robot the active part, where that is due.
  void focus();

  /// (5.1) Pairs observed walls with active ones. @returns one match per observed wall.
  std::vector<WallMatch> associate(const std::vector<ObservedWall>& observed) const;

  /// Innovation of a pairing's two offsets across the observed line.
  SparseRows line_innovation(const ObservedWall& observed, std::size_t index) const {
    return rows_for(observed, index, {});
  }

  /// (5.2.2-5.2.5) Corrects pose and map by all matched walls, one after the other.
  void correct(const std::vector<ObservedWall>& observed, const std::vector<WallMatch>& matches);

  /// (5.3.1) Lengthens matched walls that are seen to go on.
  void extend(const std::vector<ObservedWall>& observed, const std::vector<WallMatch>& matches);

  /// (5.3.2, 5.47-5.53) @returns index of the new wall.
  std::size_t add(const ObservedWall& observed);
  /// Adds what is new; names it in `matches`. @returns how many.
  int add_new(const std::vector<ObservedWall>& observed, std::vector<WallMatch>& matches);

  /// (5.3.1) Makes one wall of two: the parts are measured to lie on one line, the outermost ends
  /// stay, the others are marginalized. Index b is freed: the last wall takes its place.
  void join(std::size_t a, std::size_t b);
  /// Joins walls seen now with active ones like them, by Mahalanobis distance. @returns how many.
  int join_similar(const std::vector<WallMatch>& matches);

  /// The last wall takes the index's place.
  void remove(std::size_t index);

  /// Raises and lowers the walls' evidence by the rays of a scan; walls that fell below
  /// forget_probability are removed. @returns how many were.
  int judge(const ScanInRobot& scan);

  /// Parts of walls that stand now and were seen `min_times_seen` times, with covariances.
  Walls plan(int64_t min_times_seen, double min_length_m);

  /// Keeps a copy of the robot's pose in the state, correlated with it as it is (stochastic
  /// cloning; Roumeliotis and Burdick 2002), in place of an earlier one.
  void mark_pose();
  struct SinceMark {
    Pose2 mark_from_robot;
    Eigen::Matrix3d covariance;  ///< of (x, y, theta) in the mark's frame
  };
  /// The way from the marked pose to the robot as it is known now: what corrections moved both
  /// leaves it alone. @returns nothing before the first mark_pose().
  std::optional<SinceMark> since_mark() const;

  CompressedState& state() { return state_; }
  const CompressedState& state() const { return state_; }
  /// Blocks of all walls, in order of index.
  std::vector<int> blocks() const;

  /// Everything: what goes on from it goes on to the last bit as what it was taken from.
  struct Stored {
    /// Robot (3), walls (4 each), and where there is one the marked pose (4, the last unused).
    Eigen::VectorXd mean, first_estimate;
    Eigen::MatrixXd covariance;
    std::vector<MapWall> walls;
    bool has_mark = false;
    std::vector<int32_t> active;  ///< indices of walls in the filter's order; walls.size() = mark
    double moved_since_focus_m = 0.0;
    int64_t next_id = 0;
  };
  /// Carries out all that was put off: O(n^2).
  Stored store();
  /// @throws std::invalid_argument when sizes do not agree.
  void restore(const Stored& stored);

 private:
  WallContext context(std::size_t index) const;
  SparseRows rows_for(const ObservedWall& observed, std::size_t index, MatchedEnds ends) const;
  MatchedEnds matched_ends(const ObservedWall& observed, std::size_t index) const;
  double end_limit_m(const ObservedWall& observed, std::size_t index) const;
  void check_again(const std::vector<ObservedWall>& observed,
                   std::vector<WallMatch>& matches) const;
  std::vector<WallMatch> associate_similar(const std::vector<ObservedWall>& observed) const;
  Segment seen_in_world(const ObservedWall& observed) const;
  bool move_end(std::size_t index, const ObservedWall& observed, bool at_start);
  SparseRows line_rows(std::size_t a, std::size_t b) const;
  void vote(const ScanInRobot& scan, MapWall& wall) const;
  std::vector<int> blocks_within(double radius_m, double behind_m) const;

  WallFilterOptions options_;
  CompressedState state_;
  std::vector<MapWall> walls_;
  int mark_ = 0;  ///< block of the marked pose; 0 = none
  int64_t next_id_ = 1;
  double moved_since_focus_m_ = 0.0;  ///< by corrections
};

}  // namespace marco::slam
