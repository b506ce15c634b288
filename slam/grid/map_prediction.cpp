#include "slam/grid/map_prediction.hpp"

#include <cmath>
#include <optional>

#include "common/median.hpp"

namespace marco::slam {
namespace {

constexpr double kWrongByM = 0.3;       // another surface, not noise
constexpr double kSearchBehindM = 1.0;  // what is measured; a wall farther behind is through
constexpr int kOccupiedPercent = 50;    // more likely a wall than not

// Distance to the first occupied cell along a ray, in steps of a quarter cell; nothing when unknown
// space or the limit comes first.
std::optional<double> predicted_range_m(const GridMap& map,
                                        const Eigen::Vector2d& from,
                                        const Eigen::Vector2d& ray,
                                        double limit_m) {
  const double step_m = 0.25 * map.resolution_m;
  double range_m = 0.0;
  while (range_m < limit_m) {
    const Eigen::Vector2i cell = map.cell_of(from + range_m * ray);
    if (!map.contains(cell.x(), cell.y())) return std::nullopt;
    const int occupied = map.at(cell.x(), cell.y());
    if (occupied == GridMap::kUnknown) return std::nullopt;
    // The wall's middle is half a cell behind its edge.
    if (occupied >= kOccupiedPercent) return range_m + 0.5 * map.resolution_m;
    range_m += step_m;
  }
  return std::nullopt;
}

}  // namespace

PredictionQuality judge_prediction(const GridMap& map, const std::vector<PlacedScan>& scans) {
  PredictionQuality quality;
  std::vector<double> errors_m;
  int64_t through = 0, before = 0;
  for (const PlacedScan& scan : scans) {
    const Eigen::Vector2d from = scan.world_from_robot * scan.sensor_in_robot;
    for (Eigen::Index i = 0; i < scan.hits_in_robot.cols(); ++i) {
      const Eigen::Vector2d beam =
          scan.world_from_robot * Eigen::Vector2d(scan.hits_in_robot.col(i)) - from;
      const double measured_m = beam.norm();
      if (measured_m <= 0.0) continue;
      const auto predicted_m =
          predicted_range_m(map, from, beam / measured_m, measured_m + kSearchBehindM);
      if (!predicted_m) continue;
      errors_m.push_back(std::abs(*predicted_m - measured_m));
      through += measured_m > *predicted_m + kWrongByM ? 1 : 0;
      before += measured_m < *predicted_m - kWrongByM ? 1 : 0;
    }
  }
  quality.beams = static_cast<int64_t>(errors_m.size());
  if (errors_m.empty()) return quality;
  quality.median_error_m = median(std::move(errors_m));
  quality.through_walls = static_cast<double>(through) / static_cast<double>(quality.beams);
  quality.short_of_walls = static_cast<double>(before) / static_cast<double>(quality.beams);
  return quality;
}

}  // namespace marco::slam
