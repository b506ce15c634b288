#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/input/sensor_synchronizer.hpp"
#include "common/pose_estimate.hpp"
#include "common/trajectory.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "slam/mapper2d.hpp"
#include "slam/process/background_job.hpp"
#include "slam/process/slam_order.hpp"
#include "slam/slam.hpp"

namespace marco::slam {

/// When a checkpoint is due, and who writes it. Not thread-safe.
class CheckpointWriter {
 public:
  /// @param every_s  of message time. @param drops  counts those that could not be written
  CheckpointWriter(double every_s, process::DropCounter& drops)
      : every_s_(every_s), drops_(drops) {}

  /// From here on no scan waits for the disk.
  void write_in_background() { in_background_ = true; }
  /// Whether one is due; a clock that steps back far makes it due, too. One that is still being
  /// written is waited for by not being due.
  bool is_due(Utime utime);
  /// Waits for the disk; what follows does, too.
  void write_in_foreground();
  /// @param job  writes; throws std::runtime_error when it cannot, on a full disk
  void write(std::function<void()> job);

 private:
  double every_s_;
  process::DropCounter& drops_;
  std::optional<Utime> saved_;
  BackgroundJob job_;
  bool in_background_ = false;
};

/// The result of a scan, for judging the map afterwards.
struct UsedScan {
  int hits = 0;  ///< beams with a return in range
  bool level = true;
  bool held_out = false;
  bool matched = false;
  /// Of a held-out scan [m], deskewed: keyframes hold the points of what is drawn.
  Points2 hits_in_robot;
  Eigen::Vector2d sensor_in_robot = {0, 0};  ///< [m]
};

/// What is kept of a scan that was processed.
/// @param matched  whether a match gave it its pose
inline UsedScan used_scan(SlamInput input, bool matched) {
  UsedScan used;
  used.hits = input.scan.beams - input.scan.no_return;
  used.level = input.level;
  used.held_out = !input.may_draw;
  used.matched = matched;
  if (used.held_out) used.hits_in_robot = std::move(input.scan.hits_in_robot);
  used.sensor_in_robot = input.scan.sensor_in_robot;
  return used;
}

/// Settings common to marco-slam and marco-line-slam.
struct Mapper2dAdapterOptions {
  SynchronizerOptions input;
  double map_period_s = 5.0;  ///< the map is published this often, in message time; 0 = in the end
  int hold_out_every = 0;     ///< every Nth scan gets a pose but is not drawn; 0 = none
  std::string maps_folder = "maps";  ///< SAVE and LOCALIZE name folders below this one; "" = none
  std::string checkpoint_path;       ///< live: "" = none is written or read
  double checkpoint_every_s = 10.0;  ///< in message time

  template <class Visitor>
  void visit(Visitor& v) {
    v("input", input);
    v("map_period_s", map_period_s, kNotNegative,
      "The map is published at this interval, in message time; 0: only at the end. More on a slow "
      "network.");
    v.advanced("hold_out_every", hold_out_every, Limits{0, 1000000},
               "Every Nth scan gets a pose but is not drawn, to measure how well the map predicts "
               "it; 0: none.");
    v("maps_folder", maps_folder,
      "Folder below which SAVE and LOCALIZE name maps; empty: both are refused.");
    v("checkpoint_path", checkpoint_path,
      "File to resume from after a crash; empty: none is written.");
    v.advanced("checkpoint_every_s", checkpoint_every_s, kPositive,
               "The checkpoint is written at this interval, in message time.");
  }
};

/// Counts of the scans so far, by result.
struct MappingProgress {
  Utime newest_scan;
  Utime last_map;
  int64_t scan_count = 0;
  Trajectory live;               ///< one a scan, in order of arrival: as first published
  Trajectory odometry_at_scans;  ///< raw odometry at the same scans, where there was any
  /// One a scan, same order; filled only after keep_scans(). No checkpoint has them.
  std::vector<UsedScan> scans;

  template <class Visitor>
  void visit(Visitor& v) {
    v("newest_scan", newest_scan);
    v("last_map", last_map);
    v("scan_count", scan_count);
    v("live", live);
    v("odometry_at_scans", odometry_at_scans);
  }
};

/// What a mapper makes of one scan.
struct MappedScan {
  PoseEstimate estimate;
  bool trajectory_changed = false;  ///< older poses moved
  UsedScan used;
};

/// Messages in, a Mapper2d, messages out; scan SLAM and line SLAM say the rest. Subscribes the
/// sensors' channels (sensor_feed.hpp), SLAM_COMMAND and MAP_REQUEST; publishes SLAM_POSE for each
/// scan, TRAJECTORY and LOOP_CLOSURES when older poses moved, and both with the map at intervals,
/// on request and in the end.
///
/// Live (LcmBus) and batch (BatchBus) alike. What it does depends on the order of messages and
/// their stamps alone, never on a clock. Runs on the bus's thread.
class Mapper2dAdapter {
 public:
  virtual ~Mapper2dAdapter() = default;
  Mapper2dAdapter(const Mapper2dAdapter&) = delete;
  Mapper2dAdapter& operator=(const Mapper2dAdapter&) = delete;

  /// What follows was recorded at another time: nothing is concluded from the step between both
  /// recordings' odometry or clocks.
  void start_session();
  /// Uses the scans that still wait, optimizes a last time, publishes trajectory and map.
  virtual void finish();
  /// Keeps the result of every scan. Memory grows with the log.
  void keep_scans() { keep_scans_ = true; }
  /// Scans are ignored until resumed.
  void pause() { paused_ = true; }

  virtual const Mapper2d& mapper2d() const = 0;
  const MappingProgress& progress() const { return progress_; }
  const Trajectory& live_trajectory() const { return progress_.live; }
  const Trajectory& odometry_trajectory() const { return progress_.odometry_at_scans; }
  const std::vector<UsedScan>& scans() const { return progress_.scans; }
  const process::DropCounter& drops() const { return drops_; }
  const SensorSynchronizer& input() const { return input_; }
  /// Whether it was resumed from a checkpoint.
  bool resumed() const { return resumed_; }
  /// The reply to the oldest SLAM_COMMAND that was not taken yet; see publish_reply.
  std::optional<slam_reply_t> take_reply() { return orders_.take_reply(); }
  /// One line for PROCESS_STATUS.
  std::string state_line() const;

 protected:
  /// @param map_channel  MAP_REQUEST names it. @param bus outlives the adapter.
  /// @param warn  see process::DropCounter.
  Mapper2dAdapter(process::Bus& bus,
                  const Mapper2dAdapterOptions& options,
                  const char* map_channel,
                  std::function<void(const std::string&)> warn);

  virtual MappedScan map_scan(const SynchronizedScan& scan, bool may_draw) = 0;
  virtual void publish_map(Utime utime) = 0;
  virtual void start_mapper_session() = 0;
  virtual void finish_mapping() = 0;
  /// SAVE, LOCALIZE, RESET, SET_POSE. @throws std::invalid_argument before it changes anything.
  virtual std::string execute_on_map(const SlamOrder& order) = 0;
  /// Writes what is known now; empty: not to be saved.
  virtual std::function<void()> checkpoint_job() = 0;
  virtual std::string mapping_line() const = 0;

  /// TRAJECTORY and LOOP_CLOSURES.
  void publish_trajectory(Utime utime);
  /// No scan waits for the disk from here on.
  void write_in_background();
  /// live_trajectory() and odometry_trajectory() end here.
  void keep_no_path();

  process::Bus& bus_;
  process::DropCounter drops_;
  SlamOrders orders_{drops_};
  SensorSynchronizer input_;
  MappingProgress progress_;
  bool paused_ = false;
  bool resumed_ = false;
  CheckpointWriter checkpoints_;

 private:
  void subscribe(const char* map_channel);
  void use_complete_scans();
  void use(const SynchronizedScan& scan);
  std::string execute_command(const SlamOrder& order);

  Mapper2dAdapterOptions options_;
  bool keep_scans_ = false;
  bool path_is_kept_ = true;
};

}  // namespace marco::slam
