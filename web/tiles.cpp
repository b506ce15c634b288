#include "web/tiles.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/log/png.hpp"
#include "lcm_tools/schema/json.hpp"
#include "web/foxglove/json.hpp"

namespace marco::web {
namespace {

constexpr std::size_t kTileBytes = std::size_t{Tiles::kCells} * Tiles::kCells;

int32_t tile_of(int64_t cell) {
  return static_cast<int32_t>(cell >= 0 ? cell / Tiles::kCells
                                        : -((-cell + Tiles::kCells - 1) / Tiles::kCells));
}

bool is_unknown(const std::vector<uint8_t>& occupancy) {
  return std::all_of(occupancy.begin(), occupancy.end(),
                     [](uint8_t cell) { return cell == GridMap::kUnknown; });
}

}  // namespace

bool Tiles::begins_anew(const GridMap& map) const {
  if (tiles_.empty() || map.resolution_m != resolution_m_) return true;
  const auto lies_between = [&](double origin_m, double ours_m) {
    const double cells = (origin_m - ours_m) / resolution_m_;
    return std::abs(cells - std::round(cells)) > 0.01;
  };
  return lies_between(map.origin_m.x(), origin_x_m_) || lies_between(map.origin_m.y(), origin_y_m_);
}

Tiles::Change Tiles::set(const GridMap& map) {
  Change change;
  ++revision_;
  if (begins_anew(map)) {
    change.clear = !tiles_.empty();
    tiles_.clear();
    resolution_m_ = map.resolution_m;
    origin_x_m_ = std::remainder(map.origin_m.x(), resolution_m_);
    origin_y_m_ = std::remainder(map.origin_m.y(), resolution_m_);
  }
  const int64_t x0 = std::llround((map.origin_m.x() - origin_x_m_) / resolution_m_);
  const int64_t y0 = std::llround((map.origin_m.y() - origin_y_m_) / resolution_m_);
  std::map<Place, Tile> now;
  for (int row = tile_of(y0); row <= tile_of(y0 + map.height_cells - 1); ++row) {
    for (int column = tile_of(x0); column <= tile_of(x0 + map.width_cells - 1); ++column) {
      std::vector<uint8_t> cells(kTileBytes, GridMap::kUnknown);
      const int64_t left = std::max<int64_t>(x0, int64_t{column} * kCells);
      const int64_t right = std::min(x0 + map.width_cells, (int64_t{column} + 1) * kCells);
      const int64_t low = std::max<int64_t>(y0, int64_t{row} * kCells);
      const int64_t high = std::min(y0 + map.height_cells, (int64_t{row} + 1) * kCells);
      for (int64_t y = low; y < high; ++y) {
        const auto from = map.occupancy.begin() + (y - y0) * map.width_cells + (left - x0);
        std::copy(from, from + (right - left),
                  cells.begin() + (y - int64_t{row} * kCells) * kCells +
                      (left - int64_t{column} * kCells));
      }
      const auto before = tiles_.find({column, row});
      if (before == tiles_.end() && is_unknown(cells)) continue;
      if (before == tiles_.end() || before->second.occupancy != cells) {
        change.places.emplace_back(column, row);
        now[{column, row}] = {std::move(cells), ""};
      } else {
        now[{column, row}] = std::move(before->second);
      }
    }
  }
  for (const auto& [place, tile] : tiles_) {
    if (now.contains(place)) continue;
    // Left by a map that shrank.
    now[place] = {std::vector<uint8_t>(kTileBytes, GridMap::kUnknown), ""};
    if (!is_unknown(tile.occupancy)) change.places.push_back(place);
  }
  tiles_ = std::move(now);
  return change;
}

std::vector<Tiles::Place> Tiles::places() const {
  std::vector<Place> all;
  for (const auto& [place, tile] : tiles_) {
    if (!is_unknown(tile.occupancy)) all.push_back(place);
  }
  return all;
}

std::string Tiles::tile_json(const Place& place) const {
  const auto at = tiles_.find(place);
  if (at == tiles_.end()) return "";
  std::string& json = at->second.json;
  if (!json.empty()) return json;
  const std::string png = logs::to_png(at->second.occupancy, kCells, 1, logs::PngSize::small);
  json = R"({"x_m":)" + foxglove::number(origin_x_m_ + place.first * kCells * resolution_m_) +
         R"(,"y_m":)" + foxglove::number(origin_y_m_ + place.second * kCells * resolution_m_) +
         R"(,"width":)" + std::to_string(kCells) + R"(,"height":)" + std::to_string(kCells) +
         R"(,"png":")" +
         lcm_schema::to_base64({reinterpret_cast<const uint8_t*>(png.data()), png.size()}) + "\"}";
  return json;
}

std::string Tiles::json(const std::vector<Place>& places, bool clear) const {
  std::string json = R"({"revision":)" + std::to_string(revision_) + R"(,"resolution_m":)" +
                     foxglove::number(resolution_m_);
  if (clear) json += R"(,"clear":true)";
  json += R"(,"tiles":[)";
  bool is_first = true;
  for (const Place& place : places) {
    const std::string tile = tile_json(place);
    if (tile.empty()) continue;
    if (!std::exchange(is_first, false)) json += ',';
    json += tile;
  }
  return json + "]}";
}

}  // namespace marco::web
