#include "landmarks/sighting_correlation.hpp"

#include <algorithm>

namespace marco::slam {
namespace {

constexpr int kLongest = 64;            // sightings of a stretch
constexpr int kShortest = 8;            // ... that tells anything
constexpr int64_t kGapScans = 20;       // unseen for so long, it is another view
constexpr double kPriorStretches = 10;  // of independent sightings
constexpr double kMemory = 400;         // stretches

}  // namespace

SightingCorrelation::SightingCorrelation() : sum_(kPriorStretches), weight_(kPriorStretches) {}

void SightingCorrelation::add(int64_t landmark, const Eigen::Vector2d& innovation, int64_t scan) {
  Stretch& stretch = stretches_[landmark];
  if (stretch.count > 0 && scan - stretch.last_scan > kGapScans) close(stretch);
  stretch.last_scan = scan;
  stretch.sum += innovation;
  if (++stretch.count == kLongest) close(stretch);
}

void SightingCorrelation::close(Stretch& stretch) {
  if (stretch.count >= kShortest) {
    // Both components: the mean of two squares.
    const double factor = 0.5 * stretch.sum.squaredNorm() / stretch.count;
    const double keep = 1.0 - 1.0 / kMemory;
    sum_ = keep * sum_ + factor;
    weight_ = keep * weight_ + 1.0;
  }
  stretch = {};
}

double SightingCorrelation::noise_factor() const { return std::max(1.0, sum_ / weight_); }

}  // namespace marco::slam
