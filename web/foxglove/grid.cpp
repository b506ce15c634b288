#include "web/foxglove/grid.hpp"

#include <algorithm>
#include <limits>

#include "web/foxglove/json.hpp"

namespace marco::foxglove {
namespace {

double field(const lcm_schema::Tree& tree, std::string_view name) {
  const int node = tree.child(0, name);
  return node < 0 ? std::numeric_limits<double>::quiet_NaN()
                  : tree.number(tree.nodes[static_cast<std::size_t>(node)]);
}

}  // namespace

std::string floor_plan_json(const GridMap& map) {
  constexpr int64_t kBytes = 4;
  std::vector<uint8_t> colours;
  colours.reserve(static_cast<std::size_t>(kBytes) * map.occupancy.size());
  for (const uint8_t percent : map.occupancy) {
    const bool known = percent != GridMap::kUnknown;
    const auto grey =
        static_cast<uint8_t>(known ? 255 - 255 * std::min<int>(percent, 100) / 100 : 0);
    colours.insert(colours.end(), {grey, grey, grey, static_cast<uint8_t>(known ? 255 : 0)});
  }
  std::string json = R"(,"pose":)" + pose_json(lift({map.origin_m.x(), map.origin_m.y(), 0.0})) +
                     R"(,"column_count":)" + std::to_string(map.width_cells) +
                     R"(,"cell_size":{"x":)" + number(map.resolution_m) + R"(,"y":)" +
                     number(map.resolution_m) + R"(},"row_stride":)" +
                     std::to_string(kBytes * map.width_cells) + R"(,"cell_stride":)" +
                     std::to_string(kBytes) + R"(,"fields":[)";
  int offset = 0;
  for (const char* name : {"red", "green", "blue", "alpha"}) {
    json += (offset > 0 ? R"(,{"name":")" : R"({"name":")") + std::string(name) + R"(","offset":)" +
            std::to_string(offset) + R"(,"type":1})";  // UINT8
    ++offset;
  }
  return json + R"(],"data":")" + lcm_schema::to_base64(colours) + "\"}";
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
         lcm_schema::to_base64(tree.message.subspan(node.offset, node.bytes)) + "\"}";
}

}  // namespace marco::foxglove
