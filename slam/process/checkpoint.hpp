#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/pose_buffer.hpp"
#include "common/samples.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "slam/localization/saved_map.hpp"
#include "slam/process/used_scan.hpp"

namespace marco::slam {

/// The last poses of the robot's own sensors.
struct MotionBuffers {
  PoseBuffer odometry;
  PoseBuffer gyro_heading;  ///< integrated yaw rate as a pose's heading
  PoseBuffer pantilt;       ///< pan as x_m, tilt as y_m [rad]
};

/// What a SlamAdapter must know to go on after it died, as if nothing had been.
struct AdapterState {
  SavedMap map;
  MotionBuffers motion;
  std::map<std::string, SensorInfo> sensors;
  std::deque<LaserScan> waiting;
  Utime newest_scan;
  Utime last_grid;
  int64_t scan_count = 0;
  Trajectory live;
  Trajectory odometry_at_scans;
  std::vector<UsedScan> scans;
  int64_t received = 0;
  std::map<std::string, int64_t> drops;
};

std::string encode_adapter_state(const AdapterState& state);
/// @throws std::invalid_argument as decode_saved_map.
AdapterState decode_adapter_state(std::string_view bytes);

/// Writes `path` as a whole; what it held is kept as `path`.before.
/// @throws std::runtime_error naming the path.
void save_adapter_state(const std::filesystem::path& path, const AdapterState& state);

/// The newest whole checkpoint: `path`, or the one before where that is torn or missing; nothing
/// when there is none. @param warn  told what is wrong with a file that was not used
std::optional<AdapterState> load_adapter_state(const std::filesystem::path& path,
                                               const std::function<void(const std::string&)>& warn);

}  // namespace marco::slam
