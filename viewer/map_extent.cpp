#include "viewer/map_extent.hpp"

#include <algorithm>
#include <limits>

namespace marco::viewer {
namespace {

constexpr double kMostCellsBeyond = 0.05;  // of the known cells
constexpr double kWorthCutting = 0.9;      // of the box of all known cells, on one side at least
constexpr double kLeastAreaPart = 0.01;    // smaller areas are specks

bool known(const GridMap& grid, int x, int y) {
  return grid.contains(x, y) && grid.at(x, y) != GridMap::kUnknown;
}

class CellBox {
 public:
  void add(const Eigen::Vector2i& cell) {
    box_.min_cell = box_.min_cell.cwiseMin(cell);
    box_.end_cell = box_.end_cell.cwiseMax(cell + Eigen::Vector2i::Ones());
  }
  bool empty() const { return box_.min_cell.x() >= box_.end_cell.x(); }
  const MapExtent& extent() const { return box_; }

 private:
  MapExtent box_{Eigen::Vector2i::Constant(std::numeric_limits<int>::max()),
                 Eigen::Vector2i::Constant(std::numeric_limits<int>::lowest()), 0};
};

CellBox box_of_areas(CellMask seen) {
  CellBox box;
  const std::vector<CellArea> areas = connected_areas(std::move(seen));
  std::size_t total = 0;
  for (const CellArea& area : areas) total += area.size();
  for (const CellArea& area : areas)
    if (static_cast<double>(area.size()) >= kLeastAreaPart * static_cast<double>(total))
      for (const Eigen::Vector2i& cell : area) box.add(cell);
  return box;
}

}  // namespace

Eigen::Vector2d MapExtent::min_m(const GridMap& grid) const {
  return grid.origin_m + grid.resolution_m * min_cell.cast<double>();
}

Eigen::Vector2d MapExtent::max_m(const GridMap& grid) const {
  return grid.origin_m + grid.resolution_m * end_cell.cast<double>();
}

CellMask well_seen(const GridMap& grid) {
  CellMask known_cells(grid.width_cells, grid.height_cells);
  for (int y = 0; y < grid.height_cells; ++y)
    for (int x = 0; x < grid.width_cells; ++x) known_cells.set(x, y, known(grid, x, y));
  return opened(std::move(known_cells));
}

std::optional<MapExtent> find_extent(const GridMap& grid) {
  CellBox all;
  std::size_t known_cells = 0;
  for (int y = 0; y < grid.height_cells; ++y) {
    for (int x = 0; x < grid.width_cells; ++x) {
      if (!known(grid, x, y)) continue;
      ++known_cells;
      all.add({x, y});
    }
  }
  if (all.empty()) return std::nullopt;
  const CellBox seen = box_of_areas(well_seen(grid));
  if (seen.empty()) return all.extent();
  MapExtent cut = seen.extent();
  const Eigen::Array2d size = (cut.end_cell - cut.min_cell).cast<double>();
  const Eigen::Array2d whole = (all.extent().end_cell - all.extent().min_cell).cast<double>();
  cut.cells_beyond = known_cells;
  for (int y = cut.min_cell.y(); y < cut.end_cell.y(); ++y)
    for (int x = cut.min_cell.x(); x < cut.end_cell.x(); ++x)
      cut.cells_beyond -= known(grid, x, y) ? 1 : 0;
  const bool worth_it = (size < kWorthCutting * whole).any();
  const bool costs_little =
      static_cast<double>(cut.cells_beyond) <= kMostCellsBeyond * static_cast<double>(known_cells);
  return worth_it && costs_little ? cut : all.extent();
}

}  // namespace marco::viewer
