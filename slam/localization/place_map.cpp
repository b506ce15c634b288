#include "slam/localization/place_map.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kMaxTableCells = 8e6;  // memory, 16 MB
constexpr int kBlocks = 3000;           // bounded for each heading, before any is looked into
constexpr double kMaxAreaM2 = 4e8;
constexpr int kFreeBelowPercent = 30;
constexpr int kWallAbovePercent = 65;
constexpr double kOnWall = 0.30;  // likelihood: within 1.5 standard deviations of a wall
constexpr double kFarFromWall = 0.08;
constexpr double kBeamStepM = 0.10;
// Before its end a beam runs along what it hits: closer to it than a cell and what the poses err.
constexpr double kBeamEndM = 0.40;
constexpr double kGrazeM = 0.12;

LikelihoodPyramid make_walls(const std::vector<Keyframe>& keys, const PlaceMapOptions& options) {
  validate(options, "place_map");
  const OrientedPoints all = join_points(keys, 0, static_cast<int>(keys.size()) - 1, Pose2{});
  require(all.points.cols() > 0, "has no points for place recognition");
  const Eigen::Vector2d size = all.points.rowwise().maxCoeff() - all.points.rowwise().minCoeff();
  const double area_m2 = (size.x() + 20.0) * (size.y() + 20.0);
  require(area_m2 < kMaxAreaM2, "is larger than 400 square kilometres");
  CorrelativeMatcherOptions table;
  table.resolution_m = std::clamp(std::sqrt(area_m2 / kMaxTableCells), options.cell_m, 0.5);
  table.blur_m = std::max(options.blur_m, 0.8 * table.resolution_m);
  table.levels = options.levels;
  return {all.points, table};
}

GridMap make_grid(const std::vector<Keyframe>& keys, const OccupancyGridOptions& options) {
  OccupancyGrid grid(options);
  for (const Keyframe& key : keys) {
    grid.insert(key.world_from_robot * key.points_in_robot.points,
                key.world_from_robot * key.sensor_in_robot);
  }
  return grid.to_map();
}

}  // namespace

double clear_length_m(const Eigen::Vector2d& beam, const Eigen::Vector2d& normal) {
  const double range_m = beam.norm(), across = std::abs(beam.dot(normal)) / range_m;
  if (across < 0.1) return 0.0;
  return std::max(0.0, range_m - kBeamEndM - kGrazeM / across);
}

PlaceMap::PlaceMap(const std::vector<Keyframe>& keys, const PlaceMapOptions& options)
    : walls_(make_walls(keys, options)),
      blocks_(walls_, kBlocks),
      grid_(make_grid(keys, options.grid)) {}

PlaceMap::Likelihood PlaceMap::likelihood(const Eigen::Vector2d& point_in_map) const {
  // Between the centres of four cells.
  const Eigen::Vector2d at =
      (point_in_map - walls_.origin_m()) / walls_.resolution_m() - Eigen::Vector2d(0.5, 0.5);
  const double x0 = std::floor(at.x()), y0 = std::floor(at.y());
  constexpr double kFarCells = 1e8;  // fits an int
  if (!(std::abs(x0) < kFarCells && std::abs(y0) < kFarCells)) return {};
  const int x = static_cast<int>(x0), y = static_cast<int>(y0);
  const double a = walls_.at(0, x, y), b = walls_.at(0, x + 1, y);
  const double c = walls_.at(0, x, y + 1), d = walls_.at(0, x + 1, y + 1);
  const double u = at.x() - x0, v = at.y() - y0;
  Likelihood result;
  result.value = ((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d)) / 255.0;
  result.gradient = {((1 - v) * (b - a) + v * (d - c)) / (255.0 * walls_.resolution_m()),
                     ((1 - u) * (c - a) + u * (d - b)) / (255.0 * walls_.resolution_m())};
  return result;
}

Agreement PlaceMap::agreement(const Beams& beams, const Pose2& map_from_beams) const {
  const Points2 ends = map_from_beams * beams.ends;
  const Points2 sensors = map_from_beams * beams.sensors;
  const Eigen::Index count = ends.cols();
  int explained = 0, in_free = 0, through_wall = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double on_wall = likelihood(ends.col(i)).value;
    if (on_wall >= kOnWall) ++explained;
    if (on_wall < kFarFromWall && is_free(ends.col(i))) {
      ++in_free;
      continue;
    }
    // Every third beam says enough, and costs a hundred times what its end does.
    if (i % 3 != 0) continue;
    const Eigen::Vector2d beam = (ends.col(i) - sensors.col(i)).normalized();
    const double clear_m = beams.clear_m[static_cast<std::size_t>(i)];
    double at_m = kBeamEndM;
    while (at_m < clear_m && !is_wall(sensors.col(i) + at_m * beam)) at_m += kBeamStepM;
    if (at_m < clear_m) through_wall += 3;
  }
  const auto part = [&](int beams_so) {
    return static_cast<double>(beams_so) / static_cast<double>(count);
  };
  return {part(explained), part(in_free), part(through_wall)};
}

uint8_t PlaceMap::occupancy(const Eigen::Vector2d& point_in_map) const {
  const Eigen::Vector2i cell = grid_.cell_of(point_in_map);
  return grid_.contains(cell.x(), cell.y()) ? grid_.at(cell.x(), cell.y()) : GridMap::kUnknown;
}

bool PlaceMap::is_free(const Eigen::Vector2d& point_in_map) const {
  return occupancy(point_in_map) < kFreeBelowPercent;
}

bool PlaceMap::is_wall(const Eigen::Vector2d& point_in_map) const {
  const uint8_t percent = occupancy(point_in_map);
  return percent != GridMap::kUnknown && percent > kWallAbovePercent;
}

}  // namespace marco::slam
