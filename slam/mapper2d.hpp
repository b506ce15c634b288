#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/trajectory.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/grid/occupancy_grid.hpp"
#include "slam/map/scan_path.hpp"

namespace marco::slam {

/// What scan SLAM (MappingSession) and line SLAM (LineMapper) have in common: a map of keyframes
/// and a pose a scan, both by the newest optimization.
class Mapper2d {
 public:
  virtual ~Mapper2d() = default;

  /// One a scan, in order of input; nothing of scans that lie in no map, or in another one.
  virtual std::vector<std::optional<Pose2>> scan_poses() const = 0;
  virtual Trajectory key_trajectory() const = 0;
  virtual const std::vector<Keyframe>& keys() const = 0;
  virtual const std::vector<Loop>& loops() const = 0;
  virtual OccupancyGrid grid() const = 0;
  /// Grows whenever older poses changed.
  virtual int64_t revision() const = 0;
};

}  // namespace marco::slam
