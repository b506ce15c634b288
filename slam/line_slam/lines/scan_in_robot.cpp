#include "slam/line_slam/lines/scan_in_robot.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// One sweep of a full circle turns by no more than that.
constexpr double kFullSweepRad = 1.05 * 2.0 * std::numbers::pi;

struct BeamOrder {
  std::vector<std::size_t> source;  ///< indices of beams in order of growing bearing
  double mean_step_rad = 0.0;
};

// Neighbour by neighbour: bearings may pass from pi to -pi within the sweep.
BeamOrder order_of(const std::vector<double>& bearings_rad) {
  BeamOrder order;
  order.source.resize(bearings_rad.size());
  std::iota(order.source.begin(), order.source.end(), std::size_t{0});
  const auto step_rad = [&](std::size_t i) {
    return normalize_angle(bearings_rad[order.source[i]] - bearings_rad[order.source[i - 1]]);
  };
  double swept_rad = 0.0, sum_rad = 0.0;
  for (std::size_t i = 1; i < bearings_rad.size(); ++i) {
    swept_rad += std::abs(step_rad(i));
    sum_rad += step_rad(i);
  }
  if (swept_rad > kFullSweepRad) {  // interlaced
    std::stable_sort(order.source.begin(), order.source.end(), [&](std::size_t a, std::size_t b) {
      return normalize_angle(bearings_rad[a]) < normalize_angle(bearings_rad[b]);
    });
    sum_rad = 0.0;
    for (std::size_t i = 1; i < bearings_rad.size(); ++i) sum_rad += step_rad(i);
  } else if (sum_rad < 0.0) {
    std::reverse(order.source.begin(), order.source.end());
  }
  order.mean_step_rad = std::abs(sum_rad) / static_cast<double>(bearings_rad.size() - 1);
  return order;
}

}  // namespace

ScanInRobot to_robot_frame(const LaserScan& scan,
                           const SensorInfo& info,
                           const Pose3& robot_from_sensor,
                           const DeskewedScan& deskewed,
                           double fallback_range_sigma_m) {
  const std::size_t count = scan.size();
  require(count >= 2, "scan has fewer than two beams");
  require(scan.bearings_rad.empty() || scan.bearings_rad.size() == count,
          "scan: expected one bearing per beam");
  // A laser mounted upside down sweeps the other way round seen from above.
  const double handed = robot_from_sensor.linear()(2, 2) < 0.0 ? -1.0 : 1.0;
  std::vector<double> bearings_rad(count);
  for (std::size_t i = 0; i < count; ++i) bearings_rad[i] = handed * scan.bearing_rad(i);
  const BeamOrder order = order_of(bearings_rad);
  std::vector<Eigen::Index> hit_of_beam(count, -1);
  for (std::size_t hit = 0; hit < deskewed.beam_of_hit.size(); ++hit) {
    hit_of_beam[static_cast<std::size_t>(deskewed.beam_of_hit[hit])] =
        static_cast<Eigen::Index>(hit);
  }
  ScanInRobot result;
  result.beams.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t source = order.source[i];
    Beam& beam = result.beams[i];
    beam.range_m = static_cast<double>(scan.ranges_m[source]);
    beam.returned = hit_of_beam[source] >= 0;
    if (beam.returned) beam.hit_m = deskewed.hits_in_robot.col(hit_of_beam[source]);
  }
  result.sensor_m = deskewed.sensor_in_robot;
  result.first_bearing_rad =
      normalize_angle(deskewed.sensor_heading_rad + bearings_rad[order.source.front()]);
  result.bearing_step_rad = order.mean_step_rad;
  result.range_sigma_m = info.range_sigma_m > 0.0 ? info.range_sigma_m : fallback_range_sigma_m;
  return result;
}

Points2 hits_of(const ScanInRobot& scan) {
  Points2 hits(2, static_cast<Eigen::Index>(scan.beams.size()));
  Eigen::Index count = 0;
  for (const Beam& beam : scan.beams) {
    if (beam.returned) hits.col(count++) = beam.hit_m;
  }
  hits.conservativeResize(2, count);
  return hits;
}

}  // namespace marco::slam
