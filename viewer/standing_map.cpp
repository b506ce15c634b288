#include "viewer/standing_map.hpp"

#include <cmath>
#include <utility>

#include "viewer/cell_outlines.hpp"
#include "viewer/map_extent.hpp"

namespace marco::viewer {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3f;
using Color = std::array<uint8_t, 3>;

constexpr double kLeastWallM = 0.3;
constexpr double kSmoothEdgeDeg = 40.0;  // faces that meet at less are lit as one
constexpr Color kFloorColor{236, 236, 232};
constexpr Color kFaceColor{186, 197, 214};
constexpr Color kTopColor{72, 76, 86};

double reach_cells(const CellArea& area) {
  Vector2i low = area.front(), high = area.front();
  for (const Vector2i& cell : area) {
    low = low.cwiseMin(cell);
    high = high.cwiseMax(cell);
  }
  return (high - low + Vector2i::Ones()).cast<double>().norm();
}

// Grazing beams clear single cells of a wall: gaps of up to two cells are closed.
CellMask walls_of(const GridMap& grid) {
  CellMask occupied(grid.width_cells, grid.height_cells), walls = occupied;
  for (int y = 0; y < grid.height_cells; ++y)
    for (int x = 0; x < grid.width_cells; ++x) occupied.set(x, y, is_occupied(grid, x, y));
  for (const CellArea& area : connected_areas(closed(std::move(occupied))))
    if (reach_cells(area) * grid.resolution_m >= kLeastWallM)
      for (const Vector2i& cell : area) walls.set(cell.x(), cell.y(), true);
  return walls;
}

class MapBuilder {
 public:
  MapBuilder(const GridMap& grid, double wall_height_m)
      : grid_(grid), top_m_(static_cast<float>(wall_height_m)) {}

  TriangleMesh build() {
    const CellMask walls = walls_of(grid_);
    // The floor extends under the walls, so that their smoothed outlines leave no gap.
    add_level(well_seen(grid_), 0.0F, kFloorColor);
    add_level(walls, top_m_, kTopColor);
    if (top_m_ > 0.0F)
      for (const Outline& outline : smooth_outlines(walls)) add_faces(outline);
    return std::move(mesh_);
  }

 private:
  Vector3f at(const Vector2d& point_cells, float height_m) const {
    const Vector2d point = grid_.origin_m + grid_.resolution_m * point_cells;
    return {static_cast<float>(point.x()), static_cast<float>(point.y()), height_m};
  }

  // Corners counter-clockwise from the visible side.
  void add_quad(const std::array<Vector3f, 4>& corners,
                const std::array<Vector3f, 4>& normals,
                Color color) {
    const auto first = static_cast<uint32_t>(mesh_.vertices_m.size());
    mesh_.vertices_m.insert(mesh_.vertices_m.end(), corners.begin(), corners.end());
    mesh_.normals.insert(mesh_.normals.end(), normals.begin(), normals.end());
    mesh_.colors_rgb.insert(mesh_.colors_rgb.end(), 4, color);
    mesh_.triangles.push_back({first, first + 1, first + 2});
    mesh_.triangles.push_back({first, first + 2, first + 3});
  }

  void add_level(const CellMask& cells, float height_m, Color color) {
    const Vector3f up = Vector3f::UnitZ();
    for (const CellRectangle& part : cover_by_rectangles(cells)) {
      const Vector2d low = part.min_cell.cast<double>(), high = part.end_cell.cast<double>();
      add_quad({at(low, height_m), at({high.x(), low.y()}, height_m), at(high, height_m),
                at({low.x(), high.y()}, height_m)},
               {up, up, up, up}, color);
    }
  }

  // The wall lies at the left of its outline, so its faces look to the right.
  void add_faces(const Outline& outline) {
    const std::size_t count = outline.size();
    std::vector<Vector3f> normals;
    for (std::size_t i = 0; i < count; ++i) {
      const Vector2d along = (outline[(i + 1) % count] - outline[i]).normalized();
      normals.emplace_back(static_cast<float>(along.y()), static_cast<float>(-along.x()), 0.0F);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Vector2d &from = outline[i], &to = outline[(i + 1) % count];
      const Vector3f first = between(normals[i], normals[(i + count - 1) % count]);
      const Vector3f last = between(normals[i], normals[(i + 1) % count]);
      add_quad({at(from, 0.0F), at(to, 0.0F), at(to, top_m_), at(from, top_m_)},
               {first, last, last, first}, kFaceColor);
    }
  }

  // Where two faces meet; at a corner, the first one's own.
  static Vector3f between(const Vector3f& own, const Vector3f& neighbour) {
    static const float kSmooth = static_cast<float>(std::cos(kSmoothEdgeDeg * EIGEN_PI / 180.0));
    return own.dot(neighbour) > kSmooth ? (own + neighbour).normalized() : own;
  }

  const GridMap& grid_;
  float top_m_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh standing_map(const GridMap& grid, double wall_height_m) {
  return MapBuilder(grid, wall_height_m).build();
}

}  // namespace marco::viewer
