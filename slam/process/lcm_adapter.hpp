#pragma once

#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/pose_buffer.hpp"
#include "common/process/bus.hpp"
#include "common/process/drop_counter.hpp"
#include "common/samples.hpp"
#include "marco/map_request_t.hpp"
#include "slam/process/used_scan.hpp"
#include "slam/slam.hpp"

namespace marco::slam {

struct SlamAdapterOptions {
  SlamOptions slam;
  double level_tilt_limit_deg =
      1.0;  ///< a scan tilted more is for 3D only; odometry carries the pose
  double pan_in_scan_limit_deg = 0.1;  ///< so is one during which the laser turned more
  double map_period_s = 5.0;  ///< GRID_MAP is sent this often, in message time; 0 = at the end only
  double patience_s = 0.5;    ///< how long a scan waits for odometry and pan-tilt, in message time
  int hold_out_every = 0;     ///< every Nth scan gets a pose but is not drawn; 0 = none

  template <class Visitor>
  void visit(Visitor& v) {
    v("slam", slam);
    v("level_tilt_limit_deg", level_tilt_limit_deg, Limits{0.0, 90.0});
    v("pan_in_scan_limit_deg", pan_in_scan_limit_deg, kNotNegative);
    v("map_period_s", map_period_s, kNotNegative);
    v("patience_s", patience_s, Limits{0.0, 10.0});
    v("hold_out_every", hold_out_every, Limits{0, 1000000});
  }
};

/// Messages in, Slam, messages out. Subscribes every LIDAR channel, ODOMETRY, IMU, PANTILT_STATE,
/// SENSOR_INFO and MAP_REQUEST; publishes SLAM_POSE for each scan, TRAJECTORY and GRID_MAP.
///
/// A scan waits until odometry and pan-tilt at or after its own time are known, if there are any;
/// what is decided depends on the order of messages and their stamps alone, never on a clock.
class SlamAdapter {
 public:
  /// @param bus outlives the adapter.
  /// @param warn  see process::DropCounter.
  SlamAdapter(process::Bus& bus,
              const SlamAdapterOptions& options,
              std::function<void(const std::string&)> warn = {});

  /// What follows was recorded at another time: it goes on where the robot was left, and nothing is
  /// concluded from the step between both recordings' odometry or clocks.
  void start_session();

  /// Uses what still waits, optimizes a last time, publishes TRAJECTORY and GRID_MAP.
  void finish();

  const Slam& slam() const { return slam_; }
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
  struct Motion {
    PoseBuffer odometry;
    PoseBuffer gyro_heading;  ///< integrated yaw rate as a pose's heading
    PoseBuffer pantilt;       ///< pan as x_m, tilt as y_m [rad]
  };
  void subscribe();
  void on_scan(LaserScan scan);
  void on_imu(const ImuSample& sample);
  void use_waiting_scans();
  void use_all_waiting();
  bool ready(const LaserScan& scan) const;
  void use(const LaserScan& scan);
  /// @param first_beam, last_beam  (pan, tilt, 0) [rad] at their times
  bool is_level(const Pose2& first_beam, const Pose2& last_beam) const;
  SlamInput input_of(const LaserScan& scan, const SensorInfo& info) const;
  void publish(const LaserScan& scan, const SlamUpdate& update);
  void publish_trajectory(Utime utime);
  void publish_grid(Utime utime);

  process::Bus& bus_;
  SlamAdapterOptions options_;
  process::DropCounter drops_;
  Slam slam_;
  std::map<std::string, SensorInfo> sensors_;
  Motion motion_;
  std::deque<LaserScan> waiting_;
  Utime newest_scan_;
  Utime last_grid_;
  int64_t scan_count_ = 0;
  Trajectory live_;
  Trajectory odometry_at_scans_;
  std::vector<UsedScan> scans_;
  bool keep_scans_ = false;
};

}  // namespace marco::slam
