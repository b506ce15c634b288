#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "slam/line_slam/line_slam.hpp"
#include "slam/mapper2d.hpp"
#include "slam/slam.hpp"

namespace marco::slam {

struct LineMapperOptions {
  LineSlamOptions lines;
  SlamOptions slam;               ///< its keyframes are never culled
  bool close_loops = true;        ///< by the pose graph, where the filter alone would not
  double trusted_shift_m = 0.30;  ///< a filter farther off the pose graph than this is too sure:
  double trusted_turn_deg = 3.0;  ///< ... it is replayed along the graph's path
  double replay_sigma_m = 0.02;   ///< of that path
  double replay_sigma_deg = 0.5;

  template <class Visitor>
  void visit(Visitor& v) {
    lines.visit(v);
    v.advanced(
        "close_loops", close_loops,
        "Close loops by a pose graph where the filter alone would not. Off to see the filter by "
        "itself.");
  }
};

/// Line SLAM on the front end of scan SLAM. Scan matching says how the robot moved, in place of
/// thesis A's wheels: it works without odometry, and where wheels slip. The filter takes that
/// motion with the error model of wheels, so that walls keep their say, and estimates pose and
/// walls together.
///
/// A revisit is closed by the filter's own joint data association where its covariance allows that.
/// Where scan SLAM's pose graph contradicts it, the filter is overconfident and is replayed along
/// the graph's path; in the end always.
///
/// Deterministic; not thread-safe. Grows by about 30 kB a keyframe.
class LineMapper : public Mapper2d {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  explicit LineMapper(const LineMapperOptions& options, const Pose2& world_from_robot = {});

  /// Takes one scan. `trajectory_changed` is set when older poses moved.
  /// @param scan  the same scan, deskewed by velocity_during(); not looked at if not `input.level`
  LineSlamUpdate process(const SlamInput& input,
                         const ScanInRobot& scan,
                         LineSlamJournal* journal = nullptr);
  /// See Slam.
  ScanVelocity velocity_during(const std::optional<Pose2>& odometry_step, double duration_s) const {
    return slam_.velocity_during(odometry_step, duration_s);
  }
  /// See Slam.
  void forget_motion() { slam_.forget_motion(); }

  /// Optimizes robustly, refines all keyframes jointly, and lays the walls along their path. More
  /// scans may follow.
  void finish();

  /// By the filter; trajectory() and the other poses are by the pose graph.
  Pose2 world_from_robot() const { return lines_.world_from_robot(); }
  Walls plan() const { return lines_.plan(); }
  LineMap map() const { return lines_.map(); }
  const WallFilter& filter() const { return lines_.filter(); }

  Trajectory trajectory() const { return slam_.trajectory(); }
  std::vector<std::optional<Pose2>> scan_poses() const override;
  Trajectory key_trajectory() const override { return slam_.key_trajectory(); }
  OccupancyGrid grid() const override { return slam_.grid(); }
  const std::vector<Loop>& loops() const override { return slam_.loops(); }
  const std::vector<Keyframe>& keys() const override { return slam_.keys(); }
  int replays() const { return replays_; }  ///< how often the filter was too sure
  int64_t revision() const override { return slam_.revision(); }

  /// Everything it knows; restored, it continues as if it had never stopped.
  struct Stored {
    LineSlam::Stored lines;
    SlamState slam;
    std::vector<ScanInRobot> key_beams;  ///< one a keyframe
    Pose2 slam_pose;
    int32_t replays = 0;
  };
  Stored store() const;
  /// @throws std::invalid_argument naming what contradicts itself; nothing has changed then.
  void restore(const Stored& stored);

 private:
  bool close_loops();
  bool is_trusted() const;
  void replay();

  LineMapperOptions options_;
  Slam slam_;
  LineSlam lines_;
  std::vector<ScanInRobot> key_beams_;  ///< one a keyframe
  Pose2 slam_pose_;                     ///< of the last scan, by scan matching
  int replays_ = 0;
};

}  // namespace marco::slam
