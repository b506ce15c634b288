#include "slam/front_end/range_noise.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/median.hpp"

namespace marco::slam {
namespace {

// A point's neighbours are on its wall when they lie no farther apart than this, or this part of
// the range, and their beams no more than this.
constexpr double kNeighboursM = 0.3, kNeighboursPerRange = 0.1, kNeighboursRad = 0.2;

// Points of a scan whose median is used; scans whose median is taken: 1 to 3 s.
constexpr std::size_t kEnoughPoints = 20;
constexpr std::size_t kScans = 31;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// How far a point lies along its beam from the line through two others [m], in standard deviations
// of one range times that deviation; all three seen from the sensor.
std::optional<double> off_line(const Eigen::Vector2d& before,
                               const Eigen::Vector2d& at,
                               const Eigen::Vector2d& after) {
  const double r0 = before.norm(), r1 = at.norm(), r2 = after.norm();
  if (!(r0 > 0.0 && r1 > 0.0 && r2 > 0.0)) return std::nullopt;
  const double apart_m = (after - before).norm();
  if (apart_m > std::max(kNeighboursM, kNeighboursPerRange * r1)) return std::nullopt;
  // Sines of the angles between the beams: the line has r = whole / (last / r0 + first / r2).
  const double first = cross(before, at) / (r0 * r1), last = cross(at, after) / (r1 * r2);
  const double whole = cross(before, after) / (r0 * r2);
  if (!(first * last > 0.0) || std::abs(whole) > kNeighboursRad) return std::nullopt;
  const double on_line = whole / (last / r0 + first / r2);
  const double by_before = on_line * on_line * last / (whole * r0 * r0);
  const double by_after = on_line * on_line * first / (whole * r2 * r2);
  return std::abs(r1 - on_line) / std::sqrt(1.0 + by_before * by_before + by_after * by_after);
}

}  // namespace

std::optional<double> range_sigma_of(const Points2& points, const Eigen::Vector2d& sensor) {
  std::vector<double> off_m;
  for (Eigen::Index i = 1; i + 1 < points.cols(); ++i) {
    const auto off =
        off_line(points.col(i - 1) - sensor, points.col(i) - sensor, points.col(i + 1) - sensor);
    if (off) off_m.push_back(*off);
  }
  if (off_m.size() < kEnoughPoints) return std::nullopt;
  return kSigmaOfMedian * median(std::move(off_m));
}

void RangeNoise::add(const Points2& points, const Eigen::Vector2d& sensor) {
  const std::optional<double> sigma_m = range_sigma_of(points, sensor);
  if (!sigma_m) return;
  sigmas_m.push_back(*sigma_m);
  if (sigmas_m.size() > kScans) sigmas_m.pop_front();
}

double RangeNoise::sigma_m() const {
  return sigmas_m.empty() ? 0.0 : median(std::vector(sigmas_m.begin(), sigmas_m.end()));
}

}  // namespace marco::slam
