#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lcm_tools/schema/decoder.hpp"
#include "lcm_tools/spy/canvas.hpp"

/// Messages drawn instead of listed. A message is recognised by its fields, not by its type's name,
/// so that foreign stacks' types are drawn as well. Pure.
namespace marco::spy {

struct GrayImage {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> pixels;  ///< row by row from the top, 0 = black
};

enum class PictureKind : uint8_t { none, scan, grid, image };

/// scan: ranges[] with thetas[] or rad0 and radstep; grid: width*, height* and occupancy[] or
/// cells[]; image: width, height, row_stride, pixelformat, data[].
PictureKind picture_kind(const lcm_schema::Tree& tree);

/// Draws into rows 1 .. height - 2 of the canvas. Says in words why when it cannot.
/// @param messages the message; of a map that is sent in tiles (marco grid_map_t), all tiles.
/// @param zoom 1 = everything fits; of scans and grids: larger comes nearer to the middle.
void draw_picture(Canvas& canvas, std::span<const lcm_schema::Tree> messages, double zoom);

/// Whether `other` is a tile of the same revision as `tile`, and another place than it.
bool same_map_other_tile(const lcm_schema::Tree& tile, const lcm_schema::Tree& other);

}  // namespace marco::spy
