#include "mapping3d/clouds/point_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/pose2.hpp"
#include "lcm_tools/base/check.hpp"
#include "mapping3d/clouds/scan_lines.hpp"

namespace marco::mapping3d {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNearestM =
    0.05;  // nearer is the scanner itself, or the zero of a beam without return
// 0.2 deg all around; a wall at 7 m then has a point in each voxel of 2.5 cm.
constexpr std::size_t kMostCells = 2'000'000;
// Points in a cell, in the mean, where they lie anywhere: more leave fewer cells empty, and lose
// more points.
constexpr double kPointsOfCell = 2.0;
constexpr double kLeastStepRad = deg_to_rad(0.02), kMostStepRad = deg_to_rad(3.0);
// Columns must not all begin where a scan that sees less than all around ends.
constexpr double kAllAroundRad = deg_to_rad(355.0);
// Points of one direction are apart when they differ by so much: noise and slanted walls do not.
constexpr double kLayerM = 0.2, kLayerShare = 0.1;

struct Seen {
  uint32_t point;
  float range_m;
  double azimuth_rad;  ///< from the first column on, 0 .. 2 pi
  double elevation_rad;

  /// From the axis of the azimuths.
  double level_m() const { return static_cast<double>(range_m) * std::cos(elevation_rad); }
};

struct Directions {
  std::vector<Seen> seen;
  double first_azimuth_rad = 0.0;
  double width_rad = 0.0;  ///< of the azimuths
};

// The widest gap between azimuths lies before the first column.
void turn_to_first_column(Directions& directions) {
  std::vector<double> sorted;
  for (const Seen& one : directions.seen) sorted.push_back(one.azimuth_rad);
  std::sort(sorted.begin(), sorted.end());
  double widest = sorted.front() + 2.0 * kPi - sorted.back();
  double first = sorted.front();
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap = sorted[i] - sorted[i - 1];
    if (gap <= widest) continue;
    widest = gap;
    first = sorted[i];
  }
  directions.first_azimuth_rad = first;
  directions.width_rad = 2.0 * kPi - widest;
  for (Seen& one : directions.seen) {
    one.azimuth_rad -= first;
    if (one.azimuth_rad < 0.0) one.azimuth_rad += 2.0 * kPi;
  }
}

Directions directions_of(const std::vector<Eigen::Vector3f>& points_m) {
  Directions directions;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const Eigen::Vector3f& p = points_m[i];
    const float range_m = p.norm();
    if (!std::isfinite(range_m) || range_m < static_cast<float>(kNearestM)) continue;
    const Eigen::Vector3d way = p.cast<double>();
    directions.seen.push_back({static_cast<uint32_t>(i), range_m, std::atan2(way.y(), way.x()),
                               std::atan2(way.z(), way.head<2>().norm())});
  }
  if (!directions.seen.empty()) turn_to_first_column(directions);
  return directions;
}

// The step at which a cell has kPointsOfCell points, if they lie evenly where any lie.
double even_step_rad(const Directions& directions) {
  constexpr int kBins = 90;  // of 2 deg from pole to pole
  const double bin_rad = kPi / kBins;
  std::vector<bool> hit(2 * kBins * kBins, false);
  double area_sr = 0.0;
  for (const Seen& one : directions.seen) {
    const int row =
        std::min(kBins - 1, static_cast<int>((one.elevation_rad + 0.5 * kPi) / bin_rad));
    const int column = std::min(2 * kBins - 1, static_cast<int>(one.azimuth_rad / bin_rad));
    auto&& bin = hit[static_cast<std::size_t>(row * 2 * kBins + column)];
    if (!bin) area_sr += bin_rad * bin_rad * std::cos((row + 0.5) * bin_rad - 0.5 * kPi);
    bin = true;
  }
  return std::sqrt(kPointsOfCell * area_sr / static_cast<double>(directions.seen.size()));
}

struct Lattice {
  ScanLines rows;  ///< elevations
  ScanLines columns;
  bool is_even = false;  ///< the rows or the columns are no lines of the scanner's
};

std::vector<double> every_nth(const std::vector<double>& lines, std::size_t n) {
  std::vector<double> some;
  for (std::size_t i = 0; i < lines.size(); i += n) some.push_back(lines[i]);
  return some;
}

ScanLines even_lines(double first_rad, double width_rad, double step_rad) {
  const double step = std::clamp(step_rad, kLeastStepRad, kMostStepRad);
  return {first_rad, step, static_cast<std::size_t>(width_rad / step) + 1};
}

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// What lies nearer to the axis jitters in azimuth more than the columns lie apart.
double least_level_m(const Directions& directions) {
  std::vector<double> levels_m;
  for (const Seen& one : directions.seen) levels_m.push_back(one.level_m());
  const auto quarter = levels_m.begin() + static_cast<std::ptrdiff_t>(levels_m.size() / 4);
  std::nth_element(levels_m.begin(), quarter, levels_m.end());
  return *quarter;
}

Lattice lattice_of(const Directions& directions) {
  const double far_m = least_level_m(directions);
  std::vector<double> azimuths, far_azimuths, elevations;
  for (const Seen& one : directions.seen) {
    azimuths.push_back(one.azimuth_rad);
    if (one.level_m() >= far_m) far_azimuths.push_back(one.azimuth_rad);
    elevations.push_back(one.elevation_rad);
  }
  const auto [lowest, highest] = std::minmax_element(elevations.begin(), elevations.end());
  const double first_rad = *lowest, height_rad = *highest - *lowest;
  const std::vector<double> rows = find_lines(std::move(elevations));
  const std::vector<double> columns = complete_lines(find_lines(std::move(far_azimuths)), azimuths);
  const auto count = static_cast<double>(directions.seen.size());
  const bool has_rows = !rows.empty(), has_columns = !columns.empty();
  double even = even_step_rad(directions);
  if (has_rows && !has_columns) {
    even = directions.width_rad * kPointsOfCell * static_cast<double>(rows.size()) / count;
  }
  if (has_columns && !has_rows) {
    even = height_rad * kPointsOfCell * static_cast<double>(columns.size()) / count;
  }
  const double cells =
      (has_rows ? static_cast<double>(rows.size()) : height_rad / even + 1.0) *
      (has_columns ? static_cast<double>(columns.size()) : directions.width_rad / even + 1.0);
  const double thinner = std::max(1.0, std::sqrt(cells / static_cast<double>(kMostCells)));
  const auto nth = static_cast<std::size_t>(std::ceil(thinner));
  return {has_rows ? ScanLines(every_nth(rows, nth))
                   : even_lines(first_rad, height_rad, even * thinner),
          has_columns ? ScanLines(every_nth(columns, nth))
                      : even_lines(0.0, directions.width_rad, even * thinner),
          !has_rows || !has_columns};
}

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
void fill_gaps(GriddedCloud& result, const Lattice& lattice) {
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
  return angles_rad.empty() ? kPi : median_of(angles_rad);
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

GriddedCloud sorted_by_direction(const PointCloud& cloud, const Directions& directions) {
  const Lattice lattice = lattice_of(directions);
  GriddedCloud result;
  resize(result, lattice.rows.count(), lattice.columns.count());
  std::vector<CellContent> contents(result.point_of.size());
  for (const Seen& one : directions.seen) {
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
GriddedCloud in_its_rows(const PointCloud& cloud, const Directions& directions) {
  const std::size_t columns = cloud.points_m.size() / cloud.rows;
  const auto nth = static_cast<std::size_t>(std::ceil(std::max(
      1.0,
      std::sqrt(static_cast<double>(cloud.points_m.size()) / static_cast<double>(kMostCells)))));
  GriddedCloud result;
  resize(result, (cloud.rows + nth - 1) / nth, (columns + nth - 1) / nth);
  for (const Seen& one : directions.seen) {
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
  const Directions directions = directions_of(cloud.points_m);
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
