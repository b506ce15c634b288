#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/grid_map.hpp"

namespace marco::web {

/// A growing map as tiles of 256 x 256 cells at fixed places, so that a browser loads what changed
/// and no more, however the map's own edge moves.
class Tiles {
 public:
  static constexpr int kCells = 256;
  using Place = std::pair<int32_t, int32_t>;  ///< column and row of tiles

  struct Change {
    bool clear = false;         ///< what was sent before no longer holds
    std::vector<Place> places;  ///< of tiles that are new or other than before
  };

  /// The whole map as it is now. Cells outside of it are unknown. A map of another resolution, or
  /// one that lies between the cells of the one before, replaces it.
  Change set(const GridMap& map);

  /// All tiles that hold a known cell.
  std::vector<Place> places() const;
  bool empty() const { return tiles_.empty(); }

  /// A message of `page/tiles` with these tiles. An erased one is sent as unknown cells.
  std::string json(const std::vector<Place>& places, bool clear) const;

 private:
  struct Tile {
    std::vector<uint8_t> occupancy;
    mutable std::string json;  // made when first asked for
  };
  std::string tile_json(const Place& place) const;
  bool begins_anew(const GridMap& map) const;

  double resolution_m_ = 0.0;
  double origin_x_m_ = 0.0, origin_y_m_ = 0.0;  // of cell 0, within a cell of the world's origin
  int64_t revision_ = 0;
  std::map<Place, Tile> tiles_;
};

}  // namespace marco::web
