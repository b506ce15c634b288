#include "slam/line_slam/circles/circle_extractor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/median.hpp"
#include "common/pose2.hpp"

namespace marco::slam {
namespace {

// Three points are what a circle needs; beside a wall, which may hide a part of it, twice as many.
constexpr int kLeastHits = 3, kLeastClearHits = 6;
// A broomstick; a column; a wall that bends by 2 cm on a chord of 1.5 m, about the ranges' noise.
constexpr double kLeastRadiusM = 0.02, kPostRadiusM = 0.5, kLargestRadiusM = 15.0;
constexpr double kOutlierSigmas = 3.5;  // one of 2000 right points lies beyond
constexpr double kDecisive = 10.0;      // of a Bayes factor: Kass and Raftery 1995
// Along walls many stretches are tried, of which one may bend by chance, and a post may be a
// rounded corner or clutter.
constexpr double kDecisiveArc = 20.0, kDecisivePostInARow = 40.0;
// Of beams' spacing: a spot is as wide, and at an edge any part of it may answer.
constexpr double kSpotSigma = 0.289;
constexpr int kPassedBeams = 3;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

const std::vector<ObservedCircle>& CircleExtractor::extract(const ScanInRobot& scan,
                                                            double max_range_m) {
  scan_ = &scan;
  circles_.clear();
  take_points(scan, max_range_m);
  if (scan.bearing_step_rad <= 0.0) return circles_;
  sigma_m_ = std::max({scan.range_sigma_m, noise_of_points(), kSurfaceSigmaM});
  for (int first = 0; first < static_cast<int>(points_.size());) {
    int last = first;
    while (last + 1 < static_cast<int>(points_.size()) && !is_cut_after(last)) ++last;
    look_at_run({first, last});
    first = last + 1;
  }
  return circles_;
}

void CircleExtractor::take_points(const ScanInRobot& scan, double max_range_m) {
  points_.clear();
  sums_.assign(1, {});
  line_sums_.assign(1, {});
  for (std::size_t i = 0; i < scan.beams.size(); ++i) {
    const Beam& beam = scan.beams[i];
    if (!beam.returned || beam.range_m > max_range_m) continue;
    const Eigen::Vector2d at_m = beam.hit_m - scan.sensor_m;
    points_.push_back({at_m, at_m.norm(), static_cast<int>(i)});
    sums_.push_back(sums_.back());
    sums_.back().add_point(at_m);
    line_sums_.push_back(line_sums_.back());
    line_sums_.back().add_point(at_m.x(), at_m.y(), 1.0);
  }
}

// Of second differences of neighbouring ranges, most of which lie on one surface: their median.
double CircleExtractor::noise_of_points() const {
  constexpr std::size_t kEnough = 40;  // the median's own error is then a fifth
  std::vector<double> seconds;
  for (std::size_t i = 1; i + 1 < points_.size(); ++i) {
    if (points_[i + 1].beam - points_[i - 1].beam != 2) continue;
    seconds.push_back(
        std::abs(points_[i - 1].range_m - 2.0 * points_[i].range_m + points_[i + 1].range_m));
  }
  if (seconds.size() < kEnough) return 0.0;
  return kSigmaOfMedian * median(std::move(seconds)) / std::sqrt(6.0);
}

// A surface ends where neighbours are far apart, unless they are along a surface that beams graze:
// then the gaps beside are wide too.
bool CircleExtractor::is_cut_after(int at) const {
  constexpr double kGapM = 0.10;  // a post stands farther from a wall, or is part of it
  const auto gap_m = [this](int i) { return (point(i + 1).at_m - point(i).at_m).norm(); };
  const int lost = point(at + 1).beam - point(at).beam - 1;
  if (lost > 1) return true;
  const double spacing_m = (1 + lost) * scan_->bearing_step_rad * point(at).range_m;
  const double gap = gap_m(at);
  if (gap <= std::max(kGapM, 6.0 * sigma_m_) + 1.5 * spacing_m) return false;
  if (at == 0 || at + 2 >= static_cast<int>(points_.size())) return true;
  return gap > 2.0 * (1 + lost) * std::min(gap_m(at - 1), gap_m(at + 1));
}

RoughCircle CircleExtractor::rough(const Stretch& stretch) const {
  return fit_roughly(sums_[static_cast<std::size_t>(stretch.last) + 1] -
                     sums_[static_cast<std::size_t>(stretch.first)]);
}

// So are points on a line.
bool CircleExtractor::is_round(const Stretch& stretch) const {
  const RoughCircle circle = rough(stretch);
  return !std::isfinite(circle.rms_m) || circle.rms_m <= 1.5 * sigma_m_ + kSurfaceSigmaM;
}

// Whether a line through the points leaves more than a circle does: most stretches end here.
bool CircleExtractor::bends(const Stretch& stretch) const {
  constexpr double kWorthwhile = 3.0;  // a look by Bayes' factor, which takes the time
  LineSums sums = line_sums_[static_cast<std::size_t>(stretch.last) + 1];
  sums.add(line_sums_[static_cast<std::size_t>(stretch.first)], -1.0);
  const RoughCircle circle = rough(stretch);
  if (!std::isfinite(circle.rms_m)) return false;
  const double gain = square(fit_line(sums).rms_m) - square(circle.rms_m);
  return stretch.size() * gain > kWorthwhile * square(sigma_m_);
}

void CircleExtractor::look_at_run(const Stretch& run) {
  int first = run.first;
  while (run.last - first + 1 >= kLeastHits) {
    // The longest round stretch from here: doubled, then halved.
    int good = std::min(run.last, first + 3);
    if (!is_round({first, good})) {
      ++first;
      continue;
    }
    int bad = run.last + 1;
    for (int step = 4; good < run.last; step *= 2) {
      const int next = std::min(run.last, good + step);
      if (!is_round({first, next})) {
        bad = next;
        break;
      }
      good = next;
    }
    while (good + 1 < bad) {
      const int middle = (good + bad) / 2;
      (is_round({first, middle}) ? good : bad) = middle;
    }
    const Stretch stretch{first, good};
    const bool whole = stretch.size() == run.last - run.first + 1;
    if (whole || bends(stretch)) try_stretch(stretch, run);
    first = good + 1;
    if (!circles_.empty() && good < run.last) {
      while (first <= run.last && point(first).beam <= circles_.back().last_beam) ++first;
    }
  }
}

double CircleExtractor::spot_sigma_rad() const {
  return std::hypot(scan_->bearing_sigma_rad, kSpotSigma * scan_->bearing_step_rad);
}

CircleRay CircleExtractor::ray_to(int i) const {
  CircleRay ray;
  ray.origin_m = Eigen::Vector2d::Zero();
  ray.direction = point(i).at_m / point(i).range_m;
  ray.range_m = point(i).range_m;
  ray.range_sigma_m = std::hypot(sigma_m_, kSurfaceSigmaM);
  ray.bearing_sigma_rad = scan_->bearing_sigma_rad;
  return ray;
}

// Beams beside the run that ended behind it; beams that ended in front hide what is beside.
void CircleExtractor::add_passed(std::vector<CircleRay>& rays, const Stretch& run, int step) const {
  const int end = step > 0 ? run.last : run.first;
  const Point& edge = point(end);
  for (int k = 1; k <= kPassedBeams; ++k) {
    const int i = end + k * step;
    if (i < 0 || i >= static_cast<int>(points_.size())) return;
    const Point& beside = point(i);
    if (std::abs(beside.beam - edge.beam) > kPassedBeams) return;
    if (beside.range_m < edge.range_m - 6.0 * sigma_m_) return;
    if (beside.range_m < edge.range_m + kPostRadiusM) continue;  // a mixed echo, or near behind
    CircleRay ray = ray_to(i);
    ray.hit = false;
    ray.bearing_sigma_rad = spot_sigma_rad();
    rays.push_back(ray);
  }
}

std::vector<CircleRay> CircleExtractor::rays_of(const Stretch& stretch, const Stretch& run) const {
  std::vector<CircleRay> rays;
  for (int i = stretch.first; i <= stretch.last; ++i) {
    rays.push_back(ray_to(i));
    const bool edge = i == run.first || i == run.last;
    if (edge) rays.back().bearing_sigma_rad = spot_sigma_rad();
  }
  if (stretch.first == run.first) add_passed(rays, run, -1);
  if (stretch.last == run.last) add_passed(rays, run, 1);
  return rays;
}

// The points of the run that lie on the circle, one after the other but for single outliers.
CircleExtractor::Stretch CircleExtractor::reach_of(const FittedCircle& circle,
                                                   Stretch stretch,
                                                   const Stretch& run) const {
  constexpr int kOutliersInARow = 2;  // two points beyond: the surface has ended
  const auto lies_on = [&](int i) {
    return std::abs(residual_of(ray_to(i), circle)) <= kOutlierSigmas;
  };
  while (stretch.size() > kLeastHits && !lies_on(stretch.first)) ++stretch.first;
  while (stretch.size() > kLeastHits && !lies_on(stretch.last)) --stretch.last;
  for (int i = stretch.last + 1; i <= run.last && i - stretch.last <= kOutliersInARow + 1; ++i) {
    if (lies_on(i)) stretch.last = i;
  }
  for (int i = stretch.first - 1; i >= run.first && stretch.first - i <= kOutliersInARow + 1; --i) {
    if (lies_on(i)) stretch.first = i;
  }
  return stretch;
}

// What stands alone and is narrow is taken for a post as wide as it looks: of few points, noise
// alone would bend the algebraic circle either way.
std::optional<FittedCircle> CircleExtractor::start_of(const Stretch& stretch,
                                                      const Stretch& run) const {
  const Eigen::Vector2d middle_m = point((stretch.first + stretch.last) / 2).at_m;
  FittedCircle circle;
  const double seen_m = (point(stretch.last).at_m - point(stretch.first).at_m).norm() +
                        scan_->bearing_step_rad * middle_m.norm();
  if (stretch.size() == run.size() && seen_m < 2.0 * kPostRadiusM) {
    circle.radius_m = 0.5 * seen_m;
    circle.centre_m = middle_m * (1.0 + circle.radius_m / middle_m.norm());
    return circle;
  }
  const RoughCircle start = rough(stretch);
  if (!std::isfinite(start.rms_m) || start.radius_m > 2.0 * kLargestRadiusM) return {};
  circle.centre_m = start.centre_m;
  circle.radius_m = start.radius_m;
  circle.from_inside = (middle_m - circle.centre_m).dot(middle_m) > 0.0;
  return circle;
}

void CircleExtractor::try_stretch(Stretch stretch, const Stretch& run) {
  const std::optional<FittedCircle> start = start_of(stretch, run);
  if (!start) return;
  FittedCircle circle = *start;
  constexpr double kOutlierPart = 0.1;  // of a stretch: with more it is no circle
  for (int round = 0; round < 3; ++round) {
    std::vector<CircleRay> rays = rays_of(stretch, run);
    if (round > 0) {
      const auto is_outlier = [&](const CircleRay& ray) {
        return ray.hit && std::abs(residual_of(ray, circle)) > kOutlierSigmas;
      };
      const auto out = std::erase_if(rays, is_outlier);
      if (static_cast<double>(out) > kOutlierPart * stretch.size()) return;
    }
    const auto fitted = fit_circle(rays, circle);
    if (!fitted) return;
    circle = *fitted;
    if (round < 2) stretch = reach_of(circle, stretch, run);
  }
  add(circle, stretch, run);
}

void CircleExtractor::add(const FittedCircle& circle, const Stretch& stretch, const Stretch& run) {
  const bool alone = stretch.first == run.first && stretch.last == run.last;
  const bool is_post = circle.radius_m <= kPostRadiusM;
  const double spare = circle.hits - 3;
  if (circle.hits < kLeastHits || circle.radius_m < kLeastRadiusM ||
      circle.radius_m > kLargestRadiusM || (is_post && circle.from_inside) ||
      circle.chi2 > 1.5 * spare + 3.5 * std::sqrt(2.0 * spare) + 4.0) {
    return;
  }
  ObservedCircle found;
  found.advantage = advantage_of(circle, stretch);
  const double least = !is_post ? kDecisiveArc : alone ? kDecisive : kDecisivePostInARow;
  const double radius_sigma_m = std::sqrt(circle.covariance(2, 2));
  found.clear = circle.hits >= kLeastClearHits && found.advantage > least &&
                radius_sigma_m < 0.25 * circle.radius_m;
  if (!found.clear && !(alone && is_post)) return;
  const double excess = spare >= 8.0 ? circle.chi2 / spare : 1.0;
  found.centre_m = circle.centre_m + scan_->sensor_m;
  found.radius_m = circle.radius_m;
  found.covariance = circle.covariance * std::max(1.0, excess);
  found.from_inside = circle.from_inside;
  // Beams turn counter-clockwise; seen from outside, their hits turn the other way.
  Eigen::Vector2d from_m = point(stretch.first).at_m - circle.centre_m;
  Eigen::Vector2d to_m = point(stretch.last).at_m - circle.centre_m;
  if (!circle.from_inside) std::swap(from_m, to_m);
  found.from_rad = std::atan2(from_m.y(), from_m.x());
  found.span_rad = std::atan2(cross(from_m, to_m), from_m.dot(to_m));
  if (found.span_rad < 0.0) found.span_rad += 2.0 * std::numbers::pi;
  found.num_points = circle.hits;
  found.first_beam = point(stretch.first).beam;
  found.last_beam = point(stretch.last).beam;
  circles_.push_back(found);
}

}  // namespace marco::slam
