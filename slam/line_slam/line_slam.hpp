#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/line_map.hpp"
#include "slam/line_slam/circles/circle_extractor.hpp"
#include "slam/line_slam/ekf/wall_filter.hpp"
#include "slam/line_slam/lines/line_extractor.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

struct LineSlamOptions {
  LineExtractorOptions lines;
  WallFilterOptions filter;
  /// Scans taken near together share their errors (edges between two beams, quantized ranges), and
  /// the filter would take them for independent: it looks at the next one after this way, this turn
  /// or this many scans, and carries the pose on by odometry for those between.
  double step_m = 0.05;
  double step_deg = 2.0;
  int step_scans = 20;
  double doubt_sigma_m = 0.10;  ///< of a move that neither odometry nor a match determines
  double doubt_sigma_rad = 0.10;
  int plan_min_times_seen = 3;      ///< walls seen in fewer scans are not in the plan
  double plan_min_length_m = 0.30;  ///< nor shorter pieces

  template <class Visitor>
  void visit(Visitor& v) {
    v("extraction", lines);
    v("filter", filter);
    v.advanced("plan_min_times_seen", plan_min_times_seen, Limits{1, 1e6},
               "Walls seen in fewer scans are left out of the plan.");
    v("plan_min_length_m", plan_min_length_m, kPositive, "Shorter walls are left out of the plan.");
  }
};

/// Whether a scan may add to the map, or only gets a pose.
enum class MapUse { draw, pose_only };

/// What one scan did.
struct LineSlamUpdate {
  Pose2 world_from_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of x, y, theta [m^2, m rad, rad^2]
  bool looked = false;  ///< false: the scan was too near the last one, or not to be looked at
  int observed = 0;     ///< walls in the scan
  int matched = 0;
  int unclear = 0;  ///< like a wall of the map, but not fitting: not used
  int added = 0;
  int joined = 0;
  int removed = 0;                  ///< walls that are no longer believed in
  int walls = 0;                    ///< in the map now
  double overlap = 0.0;             ///< 0..1 of the walls' points, those on matched walls
  bool trajectory_changed = false;  ///< older poses moved: a loop was closed (LineMapper)
};

/// For inspection, where the thesis dumped its matrices.
struct LineSlamJournal {
  Eigen::Vector3d robot_predicted, robot_corrected;
  Eigen::Matrix3d covariance_predicted, covariance_corrected;
  std::vector<ObservedWall> observed;  ///< z, robot frame
  std::vector<WallMatch> matches;      ///< one per observed wall; `wall` before the map changed
  std::vector<int64_t> wall_ids;       ///< of the matches, 0 = none
  std::vector<Eigen::Matrix2d> innovation_covariances;  ///< S of each match's two offsets, else 0
  std::vector<Eigen::Vector2d> innovations;
  std::vector<Eigen::Matrix<double, 3, 2>> robot_gains;  ///< K's rows for x, y, theta
};

/// Thesis A, whole: walls out of the scan, pose and map by the filter. Lines -> predict ->
/// associate
/// -> correct -> extend, add, join -> judge. Deterministic; not thread-safe.
class LineSlam {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  explicit LineSlam(const LineSlamOptions& options, const Pose2& world_from_robot = {});

  /// Takes one scan.
  /// @param robot_motion  by odometry or scan matching since the call before, seen from the robot's
  ///                      pose then
  /// @param journal       filled when given.
  LineSlamUpdate process(const ScanInRobot& scan,
                         const Pose2& robot_motion,
                         MapUse use = MapUse::draw,
                         LineSlamJournal* journal = nullptr);

  /// The same from where another source says the robot is. @param covariance  of (x, y, theta),
  /// world frame: of this pose's own error, which no other one shares.
  LineSlamUpdate process_at(const ScanInRobot& scan,
                            const Pose2& world_from_robot,
                            const Eigen::Matrix3d& covariance);

  /// Carries the pose on without a scan (a tilted sweep, a gap).
  LineSlamUpdate carry(const Pose2& robot_motion);
  /// The next move is a guess.
  void doubt();

  /// Judges all walls again, by these scans alone, from where they were taken: what rays went
  /// through is left out of the plan, and what they met is in it. For poses known better than while
  /// driving.
  void judge_again(const std::vector<ScanInRobot>& scans,
                   const std::vector<Pose2>& world_from_robots) {
    filter_.judge_again(scans, world_from_robots);
  }

  Pose2 world_from_robot() const { return filter_.world_from_robot(); }
  /// The walls that stand now, world frame.
  Walls plan() const;
  /// These, the walls' corners, and posts and curved walls that were seen in as many scans.
  LineMap map() const;

  const WallFilter& filter() const { return filter_; }

  struct Stored {
    WallFilter::Stored filter;
    Pose2 step_from_robot;
    int32_t scans_since_step = 0;
  };
  Stored store() const;
  /// @throws std::invalid_argument as WallFilter::restore.
  void restore(const Stored& stored);

 private:
  bool step_is_due(const Pose2& robot_motion);
  LineSlamUpdate take(const ScanInRobot& scan, MapUse use, LineSlamJournal* journal);
  LineSlamUpdate report() const;
  void note(LineSlamJournal& journal,
            const std::vector<ObservedWall>& observed,
            const std::vector<WallMatch>& matches) const;

  LineSlamOptions options_;
  LineExtractor extractor_;
  CircleExtractor circle_extractor_;
  WallFilter filter_;
  Pose2 step_from_robot_;     ///< since the last scan that was looked at
  int scans_since_step_ = 0;  ///< 0 = none was yet
};

}  // namespace marco::slam
