// The map in tiles and as a whole, and the 3D model.
#include <algorithm>

#include "lcmtypes/convert.hpp"
#include "marco/mesh_t.hpp"
#include "web/foxglove/grid.hpp"
#include "web/foxglove/messages.hpp"
#include "web/process/robot_channels.hpp"

namespace marco::web {
namespace {

constexpr int kTilesAtOnce = 4;  // a few milliseconds

uint64_t slot_of(const Tiles::Place& place) {
  return static_cast<uint64_t>(static_cast<uint32_t>(place.first)) << 32U |
         static_cast<uint32_t>(place.second);
}

/// Foxglove knows no part of a map: a large one is drawn with coarser cells, each the most occupied
/// of those it holds.
GridMap reduced(const GridMap& map, std::size_t most_cells) {
  if (map.occupancy.size() <= most_cells) return map;
  GridMap half;
  half.origin_m = map.origin_m;
  half.resolution_m = 2.0 * map.resolution_m;
  half.width_cells = (map.width_cells + 1) / 2;
  half.height_cells = (map.height_cells + 1) / 2;
  half.occupancy.assign(
      static_cast<std::size_t>(half.width_cells) * static_cast<std::size_t>(half.height_cells),
      GridMap::kUnknown);
  for (int y = 0; y < map.height_cells; ++y) {
    for (int x = 0; x < map.width_cells; ++x) {
      uint8_t& cell = half.occupancy[static_cast<std::size_t>(y / 2) *
                                         static_cast<std::size_t>(half.width_cells) +
                                     static_cast<std::size_t>(x / 2)];
      const uint8_t fine = map.at(x, y);
      if (fine == GridMap::kUnknown) continue;
      cell = cell == GridMap::kUnknown ? fine : std::max(cell, fine);
    }
  }
  return reduced(half, most_cells);
}

}  // namespace

void RobotChannels::take_maps(const std::vector<JoinedGrid>& maps) {
  for (const JoinedGrid& grid : maps) {
    grid_ = grid;
    const Tiles::Change change = tiled_.set(grid.map);
    if (change.clear) {
      tiles_due_.clear();
      if (hub_.wanted(tiles_)) {
        hub_.publish_alone(tiles_, ns_of(grid.event_time), tiled_.json({}, true));
      }
    }
    for (const Tiles::Place& place : change.places) {
      if (std::find(tiles_due_.begin(), tiles_due_.end(), place) == tiles_due_.end()) {
        tiles_due_.push_back(place);
      }
    }
    if (hub_.wanted(map_)) hub_.publish(map_, ns_of(grid.event_time), map_json());
  }
}

void RobotChannels::step(Utime now) {
  take_maps(grids_.finished(now));
  if (!hub_.wanted(tiles_)) tiles_due_.clear();  // a subscriber gets all
  for (int n = 0; n < kTilesAtOnce && !tiles_due_.empty(); ++n) {
    const Tiles::Place place = tiles_due_.front();
    tiles_due_.pop_front();
    hub_.publish(tiles_, ns_of(now), tiled_.json({place}, false), 1 + slot_of(place));
  }
}

std::string RobotChannels::map_json() const {
  constexpr std::size_t kMostCells = 1 << 20;  // 4 bytes each
  return foxglove::in_frame(grid_->utime_us, kMapFrame) +
         foxglove::floor_plan_json(reduced(grid_->map, kMostCells));
}

void RobotChannels::take_model(const process::RawMessage& raw) {
  const auto message = decode_message<mesh_t>(raw.bytes);
  if (!message) throw std::invalid_argument("undecodable");
  const mesh_t& tile = *message;
  std::string json = scenes_.json("model", foxglove::stamp_json(tile.utime), kMapFrame, tile);
  if (json.empty()) throw std::invalid_argument("mesh_t: a triangle names a missing vertex");
  constexpr std::size_t kMostTiles = 4096;
  if (tile.revision != model_revision_) {
    model_revision_ = tile.revision;
    const auto tiles = static_cast<uint32_t>(tile.tiles);
    std::erase_if(model_tiles_, [tiles](const auto& one) { return one.first >= tiles; });
  }
  const auto number = static_cast<uint32_t>(tile.tile);
  if (model_tiles_.size() < kMostTiles || model_tiles_.contains(number)) {
    model_tiles_[number] = {tile.utime, json};
  }
  hub_.publish(model_, ns_of(raw.event_time), std::move(json), number);
}

}  // namespace marco::web
