#include "mapping3d/clouds/point_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/median.hpp"
#include "common/pose2.hpp"
#include "lcm_tools/base/check.hpp"
#include "mapping3d/clouds/scan_directions.hpp"

namespace marco::mapping3d {
namespace {

// Columns must not all begin where a scan that sees less than all around ends.
constexpr double kAllAroundRad = deg_to_rad(355.0);
// Points of one direction are apart when they differ by so much: noise and slanted walls do not.
constexpr double kLayerM = 0.2, kLayerShare = 0.1;

// What a cell holds while it is filled.
struct CellContent {
  float off = std::numeric_limits<float>::infinity();  ///< of the point taken, from the middle
  float nearest_m = std::numeric_limits<float>::infinity();
  float farthest_m = 0.0F;
};

void take(GriddedCloud& result, const PointCloud& cloud, std::size_t cell, uint32_t point) {
  result.scene.points_m[cell] = cloud.points_m[point];
  result.scene.valid[cell] = 1;
  result.point_of[cell] = point;
}

void resize(GriddedCloud& result, std::size_t rows, std::size_t columns) {
  result.scene.rows = rows;
  result.scene.columns = columns;
  result.scene.points_m.assign(rows * columns, Eigen::Vector3f::Zero());
  result.scene.valid.assign(rows * columns, 0);
  result.scene.origins_m.assign(rows, Eigen::Vector3f::Zero());
  result.point_of.assign(rows * columns, GriddedCloud::kNoPoint);
}

double layered_part(const std::vector<CellContent>& contents) {
  std::size_t filled = 0, layered = 0;
  for (const CellContent& content : contents) {
    if (content.farthest_m <= 0.0F) continue;
    ++filled;
    const float apart_m = content.farthest_m - content.nearest_m;
    const auto least_m =
        static_cast<float>(kLayerM) + static_cast<float>(kLayerShare) * content.nearest_m;
    layered += apart_m > least_m ? 1 : 0;
  }
  return filled == 0 ? 0.0 : static_cast<double>(layered) / static_cast<double>(filled);
}

// Fills short gaps between two points of a row that one surface explains.
void fill_gaps(GriddedCloud& result, const DirectionLattice& lattice) {
  constexpr double kLongestGap = 2.5;    // in steps on the sphere
  constexpr float kSameSurface = 0.05F;  // change of the range, of the range
  ScenePoints& scene = result.scene;
  for (std::size_t row = 0; row < scene.rows; ++row) {
    // Towards the poles the columns come close together.
    const double across = std::max(0.02, std::cos(lattice.rows.angle_rad(row)));
    const auto longest = static_cast<std::size_t>(kLongestGap / across);
    std::size_t last = scene.columns;
    for (std::size_t column = 0; column < scene.columns; ++column) {
      const std::size_t at = scene.index(row, column);
      if (scene.valid[at] == 0) continue;
      const std::size_t from = scene.index(row, last);
      const std::size_t gap = last == scene.columns ? 0 : column - last;
      if (gap > 1 && gap <= longest) {
        const Eigen::Vector3f a = scene.points_m[from], b = scene.points_m[at];
        if (std::abs(a.norm() - b.norm()) <
            kSameSurface * static_cast<float>(gap) * std::min(a.norm(), b.norm())) {
          for (std::size_t k = 1; k < gap; ++k) {
            const float part = static_cast<float>(k) / static_cast<float>(gap);
            scene.points_m[from + k] = a + part * (b - a);
            scene.valid[from + k] = 1;
          }
        }
      }
      last = column;
    }
  }
}

// The angle between the first and the last beam of the rows, or of the columns, that both returned.
double angle_across(const ScenePoints& scene, bool of_rows) {
  std::vector<double> angles_rad;
  const std::size_t count = of_rows ? scene.rows : scene.columns;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t a = of_rows ? scene.index(i, 0) : scene.index(0, i);
    const std::size_t b =
        of_rows ? scene.index(i, scene.columns - 1) : scene.index(scene.rows - 1, i);
    if (scene.valid[a] == 0 || scene.valid[b] == 0) continue;
    const Eigen::Vector3f from = scene.points_m[a], to = scene.points_m[b];
    angles_rad.push_back(std::atan2(from.cross(to).norm(), from.dot(to)));
  }
  return angles_rad.empty() ? std::numbers::pi : median(std::move(angles_rad));
}

// Appends the first column, or row, after the last one, its neighbour.
void close_around(GriddedCloud& result, bool by_columns) {
  const GriddedCloud open = std::move(result);
  const ScenePoints& from = open.scene;
  result = {};
  resize(result, from.rows + (by_columns ? 0 : 1), from.columns + (by_columns ? 1 : 0));
  result.layered = open.layered;
  for (std::size_t row = 0; row < result.scene.rows; ++row) {
    for (std::size_t column = 0; column < result.scene.columns; ++column) {
      const std::size_t source = from.index(row % from.rows, column % from.columns);
      const std::size_t to = result.scene.index(row, column);
      result.scene.points_m[to] = from.points_m[source];
      result.scene.valid[to] = from.valid[source];
      result.point_of[to] = open.point_of[source];
    }
  }
}

GriddedCloud sorted_by_direction(const PointCloud& cloud, const ScanDirections& directions) {
  const DirectionLattice lattice = lattice_of(directions);
  GriddedCloud result;
  resize(result, lattice.rows.count(), lattice.columns.count());
  std::vector<CellContent> contents(result.point_of.size());
  for (const ScanDirection& one : directions.seen) {
    const std::size_t row = lattice.rows.at(one.elevation_rad);
    const std::size_t column = lattice.columns.at(one.azimuth_rad);
    const std::size_t cell = result.scene.index(row, column);
    CellContent& content = contents[cell];
    content.nearest_m = std::min(content.nearest_m, one.range_m);
    content.farthest_m = std::max(content.farthest_m, one.range_m);
    const auto off =
        static_cast<float>(std::abs(one.elevation_rad - lattice.rows.angle_rad(row)) +
                           std::abs(one.azimuth_rad - lattice.columns.angle_rad(column)));
    if (off >= content.off) continue;
    content.off = off;
    take(result, cloud, cell, one.point);
  }
  result.layered = layered_part(contents);
  if (lattice.is_even) fill_gaps(result, lattice);
  return result;
}

// Rows and columns as the file has them, of many every nth.
GriddedCloud in_its_rows(const PointCloud& cloud, const ScanDirections& directions) {
  const std::size_t columns = cloud.points_m.size() / cloud.rows;
  const auto nth = static_cast<std::size_t>(std::ceil(std::max(
      1.0,
      std::sqrt(static_cast<double>(cloud.points_m.size()) / static_cast<double>(kMostCells)))));
  GriddedCloud result;
  resize(result, (cloud.rows + nth - 1) / nth, (columns + nth - 1) / nth);
  for (const ScanDirection& one : directions.seen) {
    const std::size_t row = one.point / columns, column = one.point % columns;
    if (row % nth != 0 || column % nth != 0) continue;
    take(result, cloud, result.scene.index(row / nth, column / nth), one.point);
  }
  return result;
}

}  // namespace

GriddedCloud grid(const PointCloud& cloud) {
  require(cloud.rows == 0 || cloud.points_m.size() % cloud.rows == 0,
          "grid: the points do not fill their rows");
  require(cloud.points_m.size() < GriddedCloud::kNoPoint, "grid: too many points");
  const ScanDirections directions = directions_of(cloud.points_m);
  if (directions.seen.size() < 2) return {};
  const bool is_organized = cloud.rows > 1 && cloud.points_m.size() / cloud.rows > 1;
  GriddedCloud result =
      is_organized ? in_its_rows(cloud, directions) : sorted_by_direction(cloud, directions);
  if (directions.width_rad > kAllAroundRad) {
    const ScenePoints& scene = result.scene;
    close_around(result, !is_organized || angle_across(scene, true) < angle_across(scene, false));
  }
  return result;
}

}  // namespace marco::mapping3d
