#pragma once

#include <deque>
#include <fstream>
#include <functional>
#include <map>
#include <optional>

#include "common/pose_buffer.hpp"
#include "common/samples.hpp"
#include "common/trajectory.hpp"
#include "lcm_tools/process/bus.hpp"
#include "slam/input/range_units.hpp"
#include "slam/line_slam/line_mapper.hpp"
#include "slam/process/line_checkpoint.hpp"
#include "slam/process/line_process_options.hpp"
#include "slam/process/one_source.hpp"
#include "slam/process/slam_order.hpp"
#include "slam/process/used_scan.hpp"

namespace marco::slam {

/// LIDAR + ODOMETRY + SENSOR_INFO (+ PANTILT_STATE, SLAM_COMMAND, MAP_REQUEST) -> SLAM_POSE,
/// LINE_MAP and, when older poses moved, TRAJECTORY. Live (LcmBus) and batch (BatchBus) alike; time
/// is the messages' only.
///
/// A scan waits in a queue until odometry covers it, or options.odometry_wait_s of log time have
/// passed; then its pose is reckoned on from the newest, or, without any odometry, guessed from the
/// last motion. Tilted scans are passed by: the pose is carried on by odometry.
/// Runs on the bus' thread. The bus must outlive it.
class LineLcmAdapter {
 public:
  /// Takes up work from options.checkpoint_path when that exists.
  /// @throws std::invalid_argument for a bad option or a damaged checkpoint.
  /// @param warn  see process::DropCounter.
  LineLcmAdapter(const LineProcessOptions& options,
                 process::Bus& bus,
                 std::function<void(const std::string&)> warn = {});

  /// What follows was recorded at another time: it must go on where the robot was left; nothing is
  /// concluded from the step between both recordings' odometry or clocks.
  void start_session();

  /// Takes the scans that still wait, closes loops for the last time, sends the map and writes the
  /// checkpoint: before the end.
  void finish();

  /// Live: only the scans of one laser are used; see OneSource.
  void keep_to_one_laser() { one_source_.emplace(); }
  /// Live: no scan waits for a map that SLAM_COMMAND asks for.
  void save_in_background() { orders_.write_in_background(); }

  /// Keeps every scan's points, for pictures and for judging held-out scans. Memory grows with the
  /// log.
  void keep_scans() { keep_scans_ = true; }

  const process::DropCounter& drops() const { return drops_; }
  /// See SlamOrders.
  std::string take_answer() { return orders_.take_answer(); }
  int64_t scans_used() const { return scans_used_; }
  int64_t scans_guessed() const { return scans_guessed_; }  ///< without odometry
  bool resumed() const { return resumed_; }
  LineMapper& mapper() { return mapper_; }
  const LineMapper& mapper() const { return mapper_; }
  /// Pose at each scan taken, in order of arrival, as first published.
  const Trajectory& live_trajectory() const { return live_; }
  /// Raw odometry at the same scans, where there was any.
  const Trajectory& odometry_trajectory() const { return odometry_at_scans_; }
  /// One a scan, same order. Filled only after keep_scans().
  const std::vector<UsedScan>& scans() const { return scans_; }

 private:
  enum class Patience { waits, is_over };

  void subscribe();
  void on_scan(LaserScan scan);
  void let_wait(LaserScan scan);
  /// What OneSource still holds is used; the laser that is heard next is the channel's.
  void hear_lasers_anew();
  std::string obey(const SlamOrder& order);
  void take_waiting(Patience patience);
  void forget_odometry();
  bool odometry_covers(const LaserScan& scan) const;
  void take(const LaserScan& scan);
  std::optional<SensorInfo> effective_info(const LaserScan& scan, bool& is_tilted);
  std::optional<Pose2> motion_to(Utime utime, std::optional<Pose2>& odom_from_robot);
  void publish_pose(Utime utime, const LineSlamUpdate& update, bool is_carried);
  void publish_map();
  void publish_trajectory(Utime utime);
  void keep(Utime utime, bool level, bool held_out, const LineSlamUpdate& update);
  void after_scan(Utime utime);
  LineCheckpoint checkpoint();
  void try_to_save(const std::string& path);
  void reset(const Pose2& world_from_robot);

  LineProcessOptions options_;
  process::Bus& bus_;
  process::DropCounter drops_;
  SlamOrders orders_{drops_};
  LineMapper mapper_;
  PoseBuffer odometry_;
  std::optional<OneSource> one_source_;
  std::deque<LaserScan> waiting_;
  std::map<std::string, SensorInfo> sensors_;
  RangeUnits range_units_;
  std::deque<PanTiltState> pantilt_;
  std::optional<Pose2> odom_at_last_scan_;
  std::optional<Utime> last_scan_;
  ScanInRobot scan_in_robot_;
  std::ofstream journal_;
  Trajectory live_;
  Trajectory odometry_at_scans_;
  std::vector<UsedScan> scans_;
  Utime map_sent_, checkpoint_saved_;
  int64_t map_revision_ = 0;
  int64_t scans_used_ = 0, scans_guessed_ = 0, scans_carried_ = 0;
  bool keep_scans_ = false;
  bool paused_ = false;
  bool resumed_ = false;
};

}  // namespace marco::slam
