#include "mapping3d/clouds/scan_directions.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/pose2.hpp"

namespace marco::mapping3d {
namespace {

constexpr double kPi = std::numbers::pi;
// Nearer is the scanner itself, or the zero of a beam without return.
constexpr double kNearestM = 0.05;
// Points in a cell, in the mean, where they lie anywhere: more leave fewer cells empty, and lose
// more points.
constexpr double kPointsOfCell = 2.0;
constexpr double kLeastStepRad = deg_to_rad(0.02), kMostStepRad = deg_to_rad(3.0);
// The widest gap between azimuths lies before the first column.
void turn_to_first_column(ScanDirections& directions) {
  std::vector<double> sorted;
  for (const ScanDirection& one : directions.seen) sorted.push_back(one.azimuth_rad);
  std::sort(sorted.begin(), sorted.end());
  double widest = sorted.front() + 2.0 * kPi - sorted.back();
  double first = sorted.front();
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap = sorted[i] - sorted[i - 1];
    if (gap <= widest) continue;
    widest = gap;
    first = sorted[i];
  }
  directions.width_rad = 2.0 * kPi - widest;
  for (ScanDirection& one : directions.seen) {
    one.azimuth_rad -= first;
    if (one.azimuth_rad < 0.0) one.azimuth_rad += 2.0 * kPi;
  }
}

// The step at which a cell has kPointsOfCell points, if they lie evenly where any lie.
double even_step_rad(const ScanDirections& directions) {
  constexpr int kBins = 90;  // of 2 deg from pole to pole
  const double bin_rad = kPi / kBins;
  std::vector<bool> hit(2 * kBins * kBins, false);
  double area_sr = 0.0;
  for (const ScanDirection& one : directions.seen) {
    const int row =
        std::min(kBins - 1, static_cast<int>((one.elevation_rad + 0.5 * kPi) / bin_rad));
    const int column = std::min(2 * kBins - 1, static_cast<int>(one.azimuth_rad / bin_rad));
    auto&& bin = hit[static_cast<std::size_t>(row * 2 * kBins + column)];
    if (!bin) area_sr += bin_rad * bin_rad * std::cos((row + 0.5) * bin_rad - 0.5 * kPi);
    bin = true;
  }
  return std::sqrt(kPointsOfCell * area_sr / static_cast<double>(directions.seen.size()));
}

std::vector<double> every_nth(const std::vector<double>& lines, std::size_t n) {
  std::vector<double> some;
  for (std::size_t i = 0; i < lines.size(); i += n) some.push_back(lines[i]);
  return some;
}

ScanLines even_lines(double first_rad, double width_rad, double step_rad) {
  const double step = std::clamp(step_rad, kLeastStepRad, kMostStepRad);
  return {first_rad, step, static_cast<std::size_t>(width_rad / step) + 1};
}

// What lies nearer to the axis jitters in azimuth more than the columns lie apart.
double least_level_m(const ScanDirections& directions) {
  std::vector<double> levels_m;
  for (const ScanDirection& one : directions.seen) levels_m.push_back(one.level_m());
  const auto quarter = levels_m.begin() + static_cast<std::ptrdiff_t>(levels_m.size() / 4);
  std::nth_element(levels_m.begin(), quarter, levels_m.end());
  return *quarter;
}

}  // namespace

ScanDirections directions_of(const std::vector<Eigen::Vector3f>& points_m) {
  ScanDirections directions;
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

DirectionLattice lattice_of(const ScanDirections& directions) {
  const double far_m = least_level_m(directions);
  std::vector<double> azimuths, far_azimuths, elevations;
  for (const ScanDirection& one : directions.seen) {
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

}  // namespace marco::mapping3d
