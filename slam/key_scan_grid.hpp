#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/trajectory.hpp"
#include "slam/grid/occupancy_grid.hpp"
#include "slam/loop_closer.hpp"

namespace marco::slam {

/// The occupancy grid of key scans where they lie now.
OccupancyGrid draw_grid(const std::vector<KeyScan>& keys, const OccupancyGridOptions& options = {});

/// The same for key scans that grow in number and move now and then: new ones are added to what is
/// drawn, and all are drawn anew only when one has moved by more than half a cell, seen ten metres
/// away, or most are others. Of a key scan in their midst that has gone, what it drew stays until
/// then. Not thread-safe.
class KeyScanGrid {
 public:
  explicit KeyScanGrid(const OccupancyGridOptions& options = {});

  /// Cost: the new key scans', mostly. Valid until the next call.
  const OccupancyGrid& update(const std::vector<KeyScan>& keys);

  /// A part of what update() would do: draws this many key scans at most. Until a drawing anew is
  /// complete, grid() shows the old one. For who must not wait. @returns whether nothing is left.
  bool advance(const std::vector<KeyScan>& keys, int at_most);
  const OccupancyGrid& grid() const { return grid_; }

  /// How often all were drawn.
  int times_redrawn() const { return times_redrawn_; }

 private:
  /// How many of the first key scans are in the grid and lie as they were drawn; 0 = draw anew.
  std::size_t known_as_drawn(const std::vector<KeyScan>& keys);

  bool draw_more(const std::vector<KeyScan>& keys, std::size_t known, std::size_t at_most);

  OccupancyGridOptions options_;
  OccupancyGrid grid_;
  Trajectory drawn_;  ///< of each key scan in the grid
  int times_redrawn_ = 0;
  std::unique_ptr<KeyScanGrid> anew_;  ///< while all are being drawn in parts
};

}  // namespace marco::slam
