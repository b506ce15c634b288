#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "slam/grid/occupancy_grid.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// The occupancy grid of keyframes where they lie now.
OccupancyGrid draw_grid(const std::vector<Keyframe>& keys,
                        const OccupancyGridOptions& options = {});

/// The same for keyframes that grow in number and move now and then: new ones are added to what is
/// drawn. Where some have moved by more than half a cell, seen ten metres away, the tiles that they
/// touch, or touched, are redrawn from all keyframes there; where most are new, everything is. Of a
/// keyframe in their midst that has gone, what it drew stays until then. Not thread-safe.
class KeyframeGrid {
 public:
  explicit KeyframeGrid(const OccupancyGridOptions& options = {});

  /// Cost: the new keyframes', mostly. Valid until the next call.
  const OccupancyGrid& update(const std::vector<Keyframe>& keys);

  /// A part of what update() would do: draws this many keyframes at most. Until a redraw is
  /// complete, grid() shows the old one. For who must not wait. @returns whether nothing is left.
  bool advance(const std::vector<Keyframe>& keys, int at_most);
  const OccupancyGrid& grid() const { return grid_; }

  /// How often something was redrawn.
  int times_redrawn() const { return times_redrawn_; }
  /// Keyframes drawn in all, some of them again and again.
  int64_t drawn() const { return drawn_count_; }

 private:
  struct Drawn {
    Utime utime;
    Pose2 world_from_robot;
    OccupancyGrid::TileBox box;
  };
  /// What has become of the keyframes that are drawn.
  struct Change {
    bool all = false;              ///< most are others
    bool some = false;             ///< some have moved
    std::vector<Drawn> remaining;  ///< those that are still there, where they are to be drawn
    std::vector<OccupancyGrid::TileBox> touched;  ///< by those that moved: before and now
    std::vector<OccupancyGrid::TileBox> left;     ///< by those that have gone
  };
  /// Tiles that are being redrawn.
  struct Redraw {
    OccupancyGrid grid;
    OccupancyGrid::Tiles tiles;  ///< none: all
    std::vector<Drawn> keys;
    std::size_t next = 0;
  };

  Change compare(const std::vector<Drawn>& drawn, const std::vector<Keyframe>& keys) const;
  static bool same(const Change& change);
  Drawn place(const Keyframe& key) const;
  void begin_redraw(const std::vector<Keyframe>& keys, Change change);
  /// @returns whether it is complete; takes from `budget`.
  bool advance_redraw(const std::vector<Keyframe>& keys, int& budget);

  OccupancyGridOptions options_;
  OccupancyGrid grid_;
  std::vector<Drawn> drawn_;                  ///< the keyframes in the grid
  std::vector<OccupancyGrid::TileBox> left_;  ///< drawn by keyframes that have gone
  std::optional<Redraw> redraw_;
  int times_redrawn_ = 0;
  int64_t drawn_count_ = 0;
};

}  // namespace marco::slam
