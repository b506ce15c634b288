#include "viewer/cell_areas.hpp"

namespace marco::viewer {
namespace {

CellArea take_area(CellMask& mask, const Eigen::Vector2i& start) {
  CellArea area{start};
  mask.set(start.x(), start.y(), false);
  for (std::size_t next = 0; next < area.size(); ++next) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Eigen::Vector2i cell = area[next] + Eigen::Vector2i(dx, dy);
        if (!mask.at(cell.x(), cell.y())) continue;
        mask.set(cell.x(), cell.y(), false);
        area.push_back(cell);
      }
    }
  }
  return area;
}

bool whole_run(const CellMask& mask, int from_x, int end_x, int y) {
  for (int x = from_x; x < end_x; ++x)
    if (!mask.at(x, y)) return false;
  return true;
}

}  // namespace

std::vector<CellArea> connected_areas(CellMask mask) {
  std::vector<CellArea> areas;
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x)
      if (mask.at(x, y)) areas.push_back(take_area(mask, {x, y}));
  return areas;
}

std::vector<CellRectangle> cover_by_rectangles(CellMask mask) {
  std::vector<CellRectangle> rectangles;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!mask.at(x, y)) continue;
      int end_x = x, end_y = y;
      while (mask.at(end_x, y)) ++end_x;
      while (whole_run(mask, x, end_x, end_y)) ++end_y;
      for (int taken_y = y; taken_y < end_y; ++taken_y)
        for (int taken_x = x; taken_x < end_x; ++taken_x) mask.set(taken_x, taken_y, false);
      rectangles.push_back({{x, y}, {end_x, end_y}});
    }
  }
  return rectangles;
}

}  // namespace marco::viewer
