#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/pose_buffer.hpp"
#include "common/samples.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_command_t.hpp"
#include "slam/input/range_units.hpp"
#include "slam/map/keyframe_grid.hpp"
#include "slam/process/background_job.hpp"
#include "slam/process/checkpoint.hpp"
#include "slam/process/loop_worker.hpp"
#include "slam/process/one_source.hpp"
#include "slam/process/slam_order.hpp"
#include "slam/process/used_scan.hpp"
#include "slam/session/mapping_session.hpp"

namespace marco::slam {

struct SlamAdapterOptions {
  SlamOptions slam;
  LocalizerOptions localizer;
  double level_tilt_limit_deg =
      1.0;  ///< a scan tilted more is for 3D only; odometry carries the pose
  double pan_in_scan_limit_deg = 0.1;  ///< so is one during which the laser turned more
  double map_period_s = 5.0;  ///< GRID_MAP is sent this often, in message time; 0 = at the end only
  double patience_s = 0.5;    ///< how long a scan waits for odometry and pan-tilt, in message time
  /// Live: what the second thread found is taken over so long after it was asked, in message time,
  /// or as soon as it is done when that takes longer: a run does not depend on how busy the machine
  /// was.
  double loop_delay_s = 1.0;
  double path_every_m = 0.05;        ///< live: poses nearer to each other are not kept, see Slam
  int hold_out_every = 0;            ///< every Nth scan gets a pose but is not drawn; 0 = none
  std::string maps_folder = "maps";  ///< SAVE and LOCALIZE name folders below this one
  std::string checkpoint_path;       ///< live: "" = none is written or read
  double checkpoint_every_s = 10.0;  ///< in message time

  template <class Visitor>
  void visit(Visitor& v) {
    v("slam", slam);
    v("localizer", localizer);
    v("level_tilt_limit_deg", level_tilt_limit_deg, Limits{0.0, 90.0});
    v("pan_in_scan_limit_deg", pan_in_scan_limit_deg, kNotNegative);
    v("map_period_s", map_period_s, kNotNegative);
    v("patience_s", patience_s, Limits{0.0, 10.0});
    v("loop_delay_s", loop_delay_s, kNotNegative);
    v("path_every_m", path_every_m, kNotNegative);
    v("hold_out_every", hold_out_every, Limits{0, 1000000});
    v("maps_folder", maps_folder);
    v("checkpoint_path", checkpoint_path);
    v("checkpoint_every_s", checkpoint_every_s, kPositive);
  }
};

/// Messages in, Slam, messages out. Subscribes every LIDAR channel, ODOMETRY, IMU, PANTILT_STATE,
/// SENSOR_INFO, SLAM_COMMAND and MAP_REQUEST; publishes SLAM_POSE for each scan, TRAJECTORY and
/// GRID_MAP. Takes up work from options.checkpoint_path when that exists.
///
/// A scan waits until odometry and pan-tilt at or after its own time are known, if there are any;
/// what is decided depends on the order of messages and their stamps alone, never on a clock.
///
/// Live, after close_loops_in_background(), no scan waits for a loop search, an optimization, or a
/// checkpoint's disk:
///   scans -> [this thread: match, publish] -> LoopWork -> [LoopWorker's thread] -> accept()
/// What was found is taken over before the first scan options.loop_delay_s later. A machine that
/// needs longer for it takes it over later: only then poses depend on how fast it is, and
/// late_loop_work() counts how often. Batch runs do without.
class SlamAdapter {
 public:
  /// @param bus outlives the adapter.
  /// @param warn  see process::DropCounter.
  SlamAdapter(process::Bus& bus,
              const SlamAdapterOptions& options,
              std::function<void(const std::string&)> warn = {});

  /// See MappingSession. Nothing is concluded from the step between both recordings' odometry or
  /// clocks.
  void start_session();

  /// See above. Not to be undone. Keeps a short path from here on.
  void close_loops_in_background();
  /// No path is kept that grows with time: live_trajectory() and odometry_trajectory() end here,
  /// and that of Slam follows the map. Poses do not change. Not to be undone.
  void keep_short_path();
  /// Live: of each LIDAR channel only the scans of one laser are used; see OneSource.
  void keep_to_one_laser() { one_source_.emplace(); }

  /// Uses what still waits, optimizes a last time, publishes TRAJECTORY and GRID_MAP.
  void finish();

  /// Goes on with a saved map, once it has found itself in it; or localizes in it, changing
  /// nothing.
  /// @throws std::invalid_argument for a map that holds nothing to find a place by.
  void extend(SavedMap map) { session_.extend(std::move(map)); }
  void localize(SavedMap map) { session_.localize(session_.localizer_in(std::move(map))); }
  /// Scans are passed by until resumed.
  void pause() { paused_ = true; }

  /// Everything it knows; what restore() takes goes on as if nothing had been. Mapping only.
  AdapterState state() const;
  void restore(AdapterState state);
  bool resumed() const { return resumed_; }
  int64_t late_loop_work() const { return late_loop_work_; }

  const MappingSession& session() const { return session_; }
  const Slam& slam() const { return session_.slam(); }
  /// What became of the oldest SLAM_COMMAND not told of yet, for a person; "" = nothing new. Live,
  /// a SAVE is told of when the map is written.
  std::string take_answer() { return orders_.take_answer(); }
  /// One line for a person: what it is doing.
  std::string state_line() const;
  const process::DropCounter& drops() const { return drops_; }
  /// One a scan, in the order of arrival: as first published.
  const Trajectory& live_trajectory() const { return live_; }
  /// Raw odometry at the same scans; empty when there was none at the first scan.
  const Trajectory& odometry_trajectory() const { return odometry_at_scans_; }
  /// One a scan, same order. Filled only after keep_scans().
  const std::vector<UsedScan>& scans() const { return scans_; }
  /// Keeps what became of every scan, and the points of those held out.
  void keep_scans() { keep_scans_ = true; }

 private:
  void subscribe();
  void on_scan(LaserScan scan);
  void let_wait(LaserScan scan);
  /// What OneSource still holds is used; the laser that is heard next is the channel's.
  void hear_lasers_anew();
  void on_imu(const ImuSample& sample);
  void use_waiting_scans();
  void use_all_waiting();
  bool ready(const LaserScan& scan) const;
  void use(const LaserScan& scan);
  /// @returns whether older poses moved.
  bool exchange_loop_work(Utime utime);
  /// @param first_beam, last_beam  (pan, tilt, 0) [rad] at their times
  bool is_level(const Pose2& first_beam, const Pose2& last_beam) const;
  Velocity2 velocity_during(const LaserScan& scan, double duration_s) const;
  SlamInput input_of(const LaserScan& scan, const SensorInfo& info) const;
  void publish(const LaserScan& scan, const SlamUpdate& update);
  void publish_trajectory(Utime utime);
  void publish_grid(Utime utime);
  /// Says once that a part of the map is left out.
  void note_size(const OccupancyGrid& grid);
  std::string obey(const SlamOrder& order);
  std::string save(const std::filesystem::path& folder);
  void save_checkpoint_now_and_then(Utime utime);
  void note_checkpoint(bool written);

  process::Bus& bus_;
  SlamAdapterOptions options_;
  process::DropCounter drops_;
  SlamOrders orders_{drops_};
  MappingSession session_;
  KeyframeGrid grid_;  ///< as last published
  std::map<std::string, SensorInfo> sensors_;
  RangeUnits range_units_;
  MotionBuffers motion_;
  std::optional<std::map<std::string, OneSource>> one_source_;  ///< by channel
  std::deque<LaserScan> waiting_;
  Utime newest_scan_;
  Utime last_grid_;
  int64_t scan_count_ = 0;
  Trajectory live_;
  Trajectory odometry_at_scans_;
  std::vector<UsedScan> scans_;
  bool keep_scans_ = false;
  bool path_is_short_ = false;
  bool odometry_is_parted_ = false;  ///< it began anew, and no scan has been used since
  bool paused_ = false;
  bool too_large_ = false;  ///< as said by note_size()
  bool resumed_ = false;
  std::optional<Utime> checkpoint_saved_;
  BackgroundJob checkpoint_;                 ///< live
  std::unique_ptr<LoopWorker> loop_worker_;  ///< nullptr: each scan waits for its loops
  Utime loop_work_asked_;
  bool loop_work_is_late_ = false;
  int64_t late_loop_work_ = 0;
};

}  // namespace marco::slam
