#include "slam/map/range_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace marco::slam {
namespace {

// Across a wall that was seen, and along it beyond its points: then a point lies on it.
constexpr double kOnWallM = 0.15;
constexpr double kAlongWallM = 1.0;
// Three standard deviations of two scans of 5 cm noise, and what turns them against each other.
constexpr double kInFrontM = 0.30, kInFrontPerM = 0.01;
// Beams farther apart than this may have anything between them.
constexpr int kGapBins = 5;
// A beam's bearing may be off by so much: by the heading's error, or a corner seen from elsewhere.
constexpr int kWidenBins = 2;

}  // namespace

RangeView::RangeView(const Keyframe& key) : key_(&key) {
  hit_.fill(-1);
  add_beams();
  widen();
}

int RangeView::bin_of(const Eigen::Vector2d& ray) const {
  const double turns = std::atan2(ray.y(), ray.x()) / (2.0 * std::numbers::pi) + 0.5;
  return std::min(kBins - 1, static_cast<int>(turns * kBins));
}

void RangeView::add_beams() {
  const Points2& points = key_->points_in_robot.points;
  int before = -1;
  double before_m = 0.0;
  const auto count = std::min<Eigen::Index>(points.cols(), INT16_MAX);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d ray = points.col(i) - key_->sensor_in_robot;
    const double range_m = ray.norm();
    const int bin = bin_of(ray);
    const auto place = static_cast<std::size_t>(bin);
    if (hit_[place] < 0 || range_m < double{free_m_[place]}) {
      free_m_[place] = static_cast<float>(range_m);
      hit_[place] = static_cast<int16_t>(i);
    }
    // The next beam comes from either side, and over the end of the circle.
    const int step = before < 0 ? 0 : (bin - before + kBins + kBins / 2) % kBins - kBins / 2;
    if (std::abs(step) <= kGapBins) {
      for (int between = 1; between < std::abs(step); ++between) {
        const int at = (before + (step > 0 ? between : -between) + kBins) % kBins;
        const auto gap = static_cast<std::size_t>(at);
        if (hit_[gap] >= 0) continue;
        free_m_[gap] = static_cast<float>(std::min(before_m, range_m));
        hit_[gap] = static_cast<int16_t>(2 * between < std::abs(step) ? i - 1 : i);
      }
    }
    before = bin;
    before_m = range_m;
  }
}

void RangeView::widen() {
  const std::array<float, kBins> narrow = free_m_;
  for (int bin = 0; bin < kBins; ++bin) {
    float& least = free_m_[static_cast<std::size_t>(bin)];
    for (int side = -kWidenBins; side <= kWidenBins; ++side) {
      least = std::min(least, narrow[static_cast<std::size_t>((bin + side + kBins) % kBins)]);
    }
  }
}

Seen RangeView::look_at(const Eigen::Vector2d& point_in_robot) const {
  const Eigen::Vector2d ray = point_in_robot - key_->sensor_in_robot;
  const auto bin = static_cast<std::size_t>(bin_of(ray));
  if (hit_[bin] < 0) return Seen::nothing;
  const OrientedPoints& points = key_->points_in_robot;
  const Eigen::Vector2d off = point_in_robot - points.points.col(hit_[bin]);
  const bool has_normal = points.has_normal(hit_[bin]);
  const double across_m =
      has_normal ? std::abs(points.normals.col(hit_[bin]).dot(off)) : off.norm();
  if (across_m < kOnWallM && off.norm() < kAlongWallM) return Seen::as_wall;
  const double range_m = ray.norm();
  const double margin_m = kInFrontM + kInFrontPerM * range_m;
  // A wall seen at a flat angle: the next beam hits it far behind.
  if (across_m < margin_m || range_m > double{free_m_[bin]} - margin_m) return Seen::nothing;
  return Seen::as_free;
}

}  // namespace marco::slam
