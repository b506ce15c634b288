#include "web/snapshot/tiles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/schema/json.hpp"

namespace marco::web {
namespace {

constexpr int kPngLevel = 3;  // a level higher halves the speed for 3 % of the bytes

// The world's cells [first, end) of each tile along one axis.
struct Span {
  int first = 0, end = 0;
};

std::vector<Span> cut_axis(double origin_m, double resolution_m, int cells) {
  const auto start = static_cast<int64_t>(std::llround(origin_m / resolution_m));
  const auto past_line = static_cast<int>((start % kTileCells + kTileCells) % kTileCells);
  std::vector<Span> spans;
  for (int first = 0; first < cells;) {
    const int end = std::min(cells, first == 0 ? kTileCells - past_line : first + kTileCells);
    spans.push_back({first, end});
    first = end;
  }
  return spans;
}

GridMap part_of(const GridMap& map, Span x, Span y) {
  GridMap tile;
  tile.resolution_m = map.resolution_m;
  tile.origin_m = map.origin_m + map.resolution_m * Eigen::Vector2d(x.first, y.first);
  tile.width_cells = x.end - x.first;
  tile.height_cells = y.end - y.first;
  for (int row = y.first; row < y.end; ++row) {
    const auto begin = map.occupancy.begin() + int64_t{row} * map.width_cells;
    tile.occupancy.insert(tile.occupancy.end(), begin + x.first, begin + x.end);
  }
  return tile;
}

}  // namespace

std::vector<GridMap> cut_tiles(const GridMap& map) {
  std::vector<GridMap> tiles;
  const auto columns = cut_axis(map.origin_m.x(), map.resolution_m, map.width_cells);
  for (const Span& y : cut_axis(map.origin_m.y(), map.resolution_m, map.height_cells)) {
    for (const Span& x : columns) {
      GridMap tile = part_of(map, x, y);
      const bool known = std::any_of(tile.occupancy.begin(), tile.occupancy.end(),
                                     [](uint8_t cell) { return cell != GridMap::kUnknown; });
      if (known) tiles.push_back(std::move(tile));
    }
  }
  return tiles;
}

void append_tile_json(const GridMap& tile, std::string& out) {
  require(tile.width_cells > 0 && tile.height_cells > 0, "a tile without cells");
  // imencode only reads, but cv::Mat knows no const pixels.
  const cv::Mat grey(tile.height_cells, tile.width_cells, CV_8UC1,
                     const_cast<uint8_t*>(tile.occupancy.data()));
  std::vector<uint8_t> png;
  cv::imencode(".png", grey, png, {cv::IMWRITE_PNG_COMPRESSION, kPngLevel});
  char head[160];
  std::snprintf(head, sizeof head, R"({"x_m":%.6f,"y_m":%.6f,"width":%d,"height":%d,"png":")",
                tile.origin_m.x(), tile.origin_m.y(), tile.width_cells, tile.height_cells);
  out += head + lcm_schema::to_base64(png) + "\"}";
}

}  // namespace marco::web
