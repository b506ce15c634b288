#include <algorithm>
#include <cmath>

#include "lcm_tools/spy/picture_fields.hpp"

namespace marco::spy {
namespace {

using lcm_schema::Node;
using lcm_schema::Tree;

enum class GridCell : uint8_t { unknown, free, occupied };

GridCell grid_cell(const Tree& tree, const Node& cells, std::size_t i, bool percent) {
  const int64_t value = tree.integer(cells, i);
  if (percent)
    return value > 100 ? GridCell::unknown : value >= 50 ? GridCell::occupied : GridCell::free;
  return value == 0 ? GridCell::unknown : value > 0 ? GridCell::occupied : GridCell::free;
}

// A tile with its place in the whole map, in cells.
struct Tile {
  const Tree* tree;
  const Node* cells;
  bool percent;
  Size size;
  double x_m;
  double y_m;
  int64_t x = 0;
  int64_t y = 0;
};

struct Map {
  std::vector<Tile> tiles;
  Size size;
  double resolution_m = 0;
};

Map map_of(std::span<const Tree> messages) {
  constexpr double kMaxCells = 1e6;  // along an edge
  Map map;
  map.resolution_m = number(messages[0], "resolution", number(messages[0], "meters_per_cell", 0));
  for (const Tree& tree : messages) {
    const Node* percent = array(tree, "occupancy");
    const Tile tile{&tree,
                    percent != nullptr ? percent : array(tree, "cells"),
                    percent != nullptr,
                    size_of(tree),
                    number(tree, "origin_x", 0),
                    number(tree, "origin_y", 0)};
    if (tile.cells == nullptr || tile.size.width == 0 ||
        static_cast<int64_t>(tile.cells->count) < tile.size.width * tile.size.height) {
      continue;
    }
    map.tiles.push_back(tile);
  }
  if (map.tiles.empty()) return map;
  double x_m = map.tiles[0].x_m;
  double y_m = map.tiles[0].y_m;
  for (const Tile& tile : map.tiles) {
    x_m = std::min(x_m, tile.x_m);
    y_m = std::min(y_m, tile.y_m);
  }
  for (Tile& tile : map.tiles) {
    const double x = (tile.x_m - x_m) / map.resolution_m;
    const double y = (tile.y_m - y_m) / map.resolution_m;
    if (x > 0 && x < kMaxCells) tile.x = std::lround(x);
    if (y > 0 && y < kMaxCells) tile.y = std::lround(y);
    map.size.width = std::max(map.size.width, tile.x + tile.size.width);
    map.size.height = std::max(map.size.height, tile.y + tile.size.height);
  }
  return map;
}

// How map cells fall on dots: dot d covers the cells first + d * step .. first + (d + 1) * step.
struct Axis {
  double first;
  double step;

  // The dots that a tile's cells [from, to) touch, among `count`.
  std::pair<int, int> dots(int64_t from, int64_t to, int count) const {
    const double low = (static_cast<double>(from) - first) / step - 1;
    const double high = (static_cast<double>(to) - first) / step + 1;
    return {static_cast<int>(std::clamp(low, 0.0, static_cast<double>(count))),
            static_cast<int>(std::clamp(high, 0.0, static_cast<double>(count)))};
  }
  // The cells of dot `d` inside [0, size) of a tile that begins at `from`.
  std::pair<int64_t, int64_t> cells(int d, int64_t from, int64_t size) const {
    const double low = std::floor(first + d * step);
    const double high = std::max(low + 1, std::floor(first + (d + 1) * step));
    return {std::clamp<int64_t>(static_cast<int64_t>(low) - from, 0, size),
            std::clamp<int64_t>(static_cast<int64_t>(high) - from, 0, size)};
  }
};

void draw_tile(
    Canvas& canvas, DotGrid& dots, const Tile& tile, const Axis& across, const Axis& up) {
  const auto [x0, x1] = across.dots(tile.x, tile.x + tile.size.width, dots.width());
  const auto [y0, y1] = up.dots(tile.y, tile.y + tile.size.height, dots.height());
  for (int y = y0; y < y1; ++y) {
    const auto [row0, row1] = up.cells(y, tile.y, tile.size.height);
    const int screen_y = dots.height() - 1 - y;
    for (int x = x0; x < x1; ++x) {
      const auto [column0, column1] = across.cells(x, tile.x, tile.size.width);
      GridCell found = GridCell::unknown;
      for (int64_t row = row0; row < row1; ++row) {
        for (int64_t column = column0; column < column1; ++column) {
          const auto cell = static_cast<std::size_t>(row * tile.size.width + column);
          found = std::max(found, grid_cell(*tile.tree, *tile.cells, cell, tile.percent));
        }
      }
      if (found == GridCell::occupied) dots.dot(x, screen_y);
      if (found == GridCell::free && x % 2 == 0 && screen_y % 4 == 1) {
        canvas.put(x / 2, 1 + screen_y / 4, U'·', Style::dim);
      }
    }
  }
}

}  // namespace

void draw_grid(Canvas& canvas, std::span<const Tree> messages, double zoom) {
  const Map map = map_of(messages);
  if (map.tiles.empty()) {
    canvas.text(2, 2, "width and height do not fit the number of cells", Style::warn);
    return;
  }
  DotGrid dots(canvas.width(), canvas.height() - 3);
  const auto width = static_cast<double>(map.size.width);
  const auto height = static_cast<double>(map.size.height);
  const double step = std::max(width / dots.width(), height / dots.height()) / zoom;
  const Axis across{(width - step * dots.width()) / 2, step};
  const Axis up{(height - step * dots.height()) / 2, step};
  for (const Tile& tile : map.tiles) draw_tile(canvas, dots, tile, across, up);
  dots.draw(canvas, 0, 1, Style::bold);
  if (map.resolution_m > 0 && map.resolution_m < 1e3)
    draw_scale(canvas, 1 / (step * map.resolution_m));
  canvas.text_right(canvas.width(), canvas.height() - 2,
                    std::to_string(map.size.width) + " x " + std::to_string(map.size.height) +
                        " cells in " + std::to_string(map.tiles.size()) +
                        (map.tiles.size() == 1 ? " tile" : " tiles") + ", y is up",
                    Style::dim);
}

}  // namespace marco::spy
