#pragma once

#include <vector>

#include "common/trajectory.hpp"
#include "slam/grid/occupancy_grid.hpp"
#include "slam/loop_closer.hpp"

namespace marco::slam {

/// The occupancy grid of key scans where they lie now.
OccupancyGrid draw_grid(const std::vector<KeyScan>& keys, const OccupancyGridOptions& options = {});

/// The same for key scans that grow in number and move now and then: new ones are added to what is
/// drawn, and all are drawn anew only when one has moved by more than half a cell, seen ten metres
/// away, or is another. Not thread-safe.
class KeyScanGrid {
 public:
  explicit KeyScanGrid(const OccupancyGridOptions& options = {});

  /// Cost: the new key scans', mostly. Valid until the next call.
  const OccupancyGrid& update(const std::vector<KeyScan>& keys);

  /// How often all were drawn.
  int times_redrawn() const { return times_redrawn_; }

 private:
  bool is_as_drawn(const std::vector<KeyScan>& keys) const;

  OccupancyGridOptions options_;
  OccupancyGrid grid_;
  Trajectory drawn_;  ///< of each key scan in the grid
  int times_redrawn_ = 0;
};

}  // namespace marco::slam
