#include "slam/process/one_laser.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "common/pose2.hpp"

namespace marco::slam {
namespace {

constexpr std::size_t kRow = 32;      // steps that tell whether stamps are steady
constexpr double kSteadyShare = 0.9;  // of them near the middle one
constexpr double kTooSoon = 0.6;      // of a step: of two lasers one comes within a half
constexpr double kMostAlike = 0.8;    // of scans that can be told by their looks
constexpr double kAlikeShare = 0.5;   // of the beams with a return
constexpr std::size_t kBeamsLookedAt = 180;

bool has_return(float range_m) {
  return std::isfinite(range_m) && range_m > 0.05F && range_m < 79.0F;
}

/// @param turned  beams by which b is turned against a.
bool alike_turned(const LaserScan& a, const LaserScan& b, long turned) {
  const auto count = static_cast<long>(a.size());
  const long every = std::max(1L, count / static_cast<long>(kBeamsLookedAt));
  int agree = 0, seen = 0;
  for (long beam = std::max(0L, -turned); beam < count && beam + turned < count; beam += every) {
    const float range_a = a.ranges_m[static_cast<std::size_t>(beam)];
    const float range_b = b.ranges_m[static_cast<std::size_t>(beam + turned)];
    if (!has_return(range_a) && !has_return(range_b)) continue;
    ++seen;
    if (std::abs(range_a - range_b) < 0.15F + 0.05F * range_a) ++agree;
  }
  return agree >= kAlikeShare * seen;
}

}  // namespace

bool look_alike(const LaserScan& a, const LaserScan& b) {
  if (a.size() != b.size()) return false;
  if (alike_turned(a, b, 0)) return true;
  const double step_rad = a.bearings_rad.empty()
                              ? std::abs(a.bearing_step_rad)
                              : deg_to_rad(360.0) / static_cast<double>(a.size() + 1);
  const auto most = step_rad > 0.0 ? static_cast<long>(deg_to_rad(15.0) / step_rad) : 0L;
  const long limit = std::min(most, static_cast<long>(a.size()) / 2);
  for (long turned = 1; turned <= limit; ++turned) {
    if (alike_turned(a, b, turned) || alike_turned(a, b, -turned)) return true;
  }
  return false;
}

bool OneLaser::too_soon(Duration step) const {
  if (steps_s_.size() < kRow) return false;
  std::vector<double> sorted(steps_s_.begin(), steps_s_.end());
  std::nth_element(sorted.begin(), sorted.begin() + kRow / 2, sorted.end());
  const double middle_s = sorted[kRow / 2];
  if (step.seconds() >= kTooSoon * middle_s) return false;
  const auto near = std::count_if(sorted.begin(), sorted.end(), [&](double s) {
    return s > 0.75 * middle_s && s < 1.25 * middle_s;
  });
  return static_cast<double>(near) >= kSteadyShare * static_cast<double>(kRow);
}

void OneLaser::learn(Duration step, bool alike) {
  steps_s_.push_back(step.seconds());
  if (steps_s_.size() > kRow) steps_s_.pop_front();
  alike_share_ += 0.1 * ((alike ? 1.0 : 0.0) - alike_share_);
}

bool OneLaser::is_ours(const LaserScan& scan) {
  const Duration step = newest_ ? scan.utime - *newest_ : Duration{};
  const bool alarmed_before = alarm_ && scan.utime - *alarm_ < kAlarm;
  if (newest_ && too_soon(step)) alarm_ = scan.utime;
  newest_ = scan.utime;
  const bool alarmed = alarm_ && scan.utime - *alarm_ < kAlarm;
  const bool alike = !trusted_ || look_alike(*trusted_, scan);
  const bool remembered = trusted_ && scan.utime - trusted_->utime < kMemory;
  if (alarmed && !alike && remembered && alike_share_ > kMostAlike) return false;
  if (!alarmed && !alarmed_before && step.us != 0) learn(step, alike);
  if (alike || !remembered || (doubtful_ && look_alike(*doubtful_, scan))) {
    trusted_ = scan;
    doubtful_.reset();
  } else {
    doubtful_ = scan;
  }
  return true;
}

}  // namespace marco::slam
