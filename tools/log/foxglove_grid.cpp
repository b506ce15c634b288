#include "tools/log/foxglove_grid.hpp"

#include <algorithm>
#include <limits>

#include "lcm_tools/log/export_json_lines.hpp"

namespace marco::logs {
namespace {

// Tiles cover a map; some may be lost.
constexpr double kMostPerTileCell = 16;
constexpr double kMostCells = 1 << 25;  // 290 m x 290 m of 5 cm
constexpr uint8_t kUnknown = 255;
constexpr Duration kPatience = Duration::from_us(50000);

bool same_place(const grid_map_t& a, const grid_map_t& b) {
  return a.origin_x_m == b.origin_x_m && a.origin_y_m == b.origin_y_m;
}

double field(const lcm_schema::Tree& tree, std::string_view name) {
  const int node = tree.child(0, name);
  return node < 0 ? std::numeric_limits<double>::quiet_NaN()
                  : tree.number(tree.nodes[static_cast<std::size_t>(node)]);
}

}  // namespace

std::string floor_plan_json(Eigen::Vector2d origin_m,
                            double resolution_m,
                            int64_t columns,
                            std::span<const uint8_t> occupancy) {
  constexpr int64_t kBytes = 4;
  std::vector<uint8_t> colours;
  colours.reserve(static_cast<std::size_t>(kBytes) * occupancy.size());
  for (const uint8_t percent : occupancy) {
    const bool known = percent != kUnknown;
    const auto grey =
        static_cast<uint8_t>(known ? 255 - 255 * std::min<int>(percent, 100) / 100 : 0);
    colours.insert(colours.end(), {grey, grey, grey, static_cast<uint8_t>(known ? 255 : 0)});
  }
  std::string json = R"(,"pose":)" + pose_json(lift({origin_m.x(), origin_m.y(), 0.0})) +
                     R"(,"column_count":)" + std::to_string(columns) + R"(,"cell_size":{"x":)" +
                     number(resolution_m) + R"(,"y":)" + number(resolution_m) +
                     R"(},"row_stride":)" + std::to_string(kBytes * columns) +
                     R"(,"cell_stride":)" + std::to_string(kBytes) + R"(,"fields":[)";
  int offset = 0;
  for (const char* name : {"red", "green", "blue", "alpha"}) {
    json += (offset > 0 ? R"(,{"name":")" : R"({"name":")") + std::string(name) + R"(","offset":)" +
            std::to_string(offset) + R"(,"type":1})";  // UINT8
    ++offset;
  }
  return json + R"(],"data":")" + to_base64(colours) + "\"}";
}

std::string mbot_grid_json(const lcm_schema::Tree& tree) {
  const int cells = tree.child(0, "cells");
  const double cell_m = field(tree, "meters_per_cell");
  const double columns = field(tree, "width");
  if (cells < 0 || !(columns >= 1 && columns < 1e9) || !(cell_m > 0.0)) return "";
  const lcm_schema::Node& node = tree.nodes[static_cast<std::size_t>(cells)];
  const std::string width = std::to_string(static_cast<int64_t>(columns));
  const std::string cell = number(cell_m);
  return R"(,"pose":)" + pose_json(lift({field(tree, "origin_x"), field(tree, "origin_y"), 0.0})) +
         R"(,"column_count":)" + width + R"(,"cell_size":{"x":)" + cell + R"(,"y":)" + cell +
         R"(},"row_stride":)" + width +
         R"(,"cell_stride":1,"fields":[{"name":"occupancy","offset":0,"type":2}],"data":")" +  // INT8
         to_base64(tree.message.subspan(node.offset, node.bytes)) + "\"}";
}

std::vector<FoxgloveMessage> GridJoiner::add(const std::string& channel,
                                             grid_map_t tile,
                                             const std::string& head,
                                             Utime event_time) {
  std::vector<FoxgloveMessage> messages;
  Map& map = maps_[channel];
  const bool belongs = std::all_of(map.tiles.begin(), map.tiles.end(), [&](const auto& other) {
    return other.revision == tile.revision && other.resolution_m == tile.resolution_m &&
           !same_place(other, tile);
  });
  if (!belongs) say(channel, map, messages);
  map.tiles.push_back(std::move(tile));
  map.head = head;
  map.event_time = event_time;
  return messages;
}

std::vector<FoxgloveMessage> GridJoiner::finished(Utime now) {
  std::vector<FoxgloveMessage> messages;
  for (auto& [channel, map] : maps_) {
    // Event times may step back a little.
    const bool is_late = now - map.event_time > kPatience || map.event_time - now > kPatience;
    if (!map.tiles.empty() && is_late) say(channel, map, messages);
  }
  return messages;
}

std::vector<FoxgloveMessage> GridJoiner::finish() {
  std::vector<FoxgloveMessage> messages;
  for (auto& [channel, map] : maps_) {
    if (!map.tiles.empty()) say(channel, map, messages);
  }
  return messages;
}

void GridJoiner::say(const std::string& channel, Map& map, std::vector<FoxgloveMessage>& messages) {
  std::string json = joined(map.tiles);
  map.tiles.clear();
  if (json.empty()) {
    ++left_out_;
    return;
  }
  if (json == map.last) return;
  messages.push_back({channel + "/Grid", "foxglove.Grid", map.head + json, map.event_time});
  map.last = std::move(json);
}

// "" when the tiles lie too far apart.
std::string GridJoiner::joined(const std::vector<grid_map_t>& tiles) {
  const double cell_m = tiles.front().resolution_m;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(HUGE_VAL), high = -low;
  double tile_cells = 0;
  for (const grid_map_t& tile : tiles) {
    const Eigen::Vector2d at(tile.origin_x_m, tile.origin_y_m);
    low = low.cwiseMin(at);
    tile_cells += static_cast<double>(tile.occupancy.size());
    high = high.cwiseMax(at + cell_m * Eigen::Vector2d(tile.width_cells, tile.height_cells));
  }
  const Eigen::Vector2d size = ((high - low) / cell_m).array().round();
  const double most_cells = std::min(kMostCells, kMostPerTileCell * tile_cells);
  if (!(size.x() * size.y() <= most_cells)) return "";
  const auto columns = static_cast<std::ptrdiff_t>(size.x());
  const auto rows = static_cast<std::ptrdiff_t>(size.y());
  std::vector<uint8_t> cells(static_cast<std::size_t>(size.x() * size.y()), kUnknown);
  for (const grid_map_t& tile : tiles) {
    const auto x = static_cast<std::ptrdiff_t>(std::round((tile.origin_x_m - low.x()) / cell_m));
    const auto y = static_cast<std::ptrdiff_t>(std::round((tile.origin_y_m - low.y()) / cell_m));
    if (x + tile.width_cells > columns || y + tile.height_cells > rows) continue;
    for (std::ptrdiff_t row = 0; row < tile.height_cells; ++row) {
      const auto from = tile.occupancy.begin() + row * tile.width_cells;
      std::copy(from, from + tile.width_cells, cells.begin() + (y + row) * columns + x);
    }
  }
  return floor_plan_json(low, cell_m, columns, cells);
}

}  // namespace marco::logs
