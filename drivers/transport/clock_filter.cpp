#include "drivers/transport/clock_filter.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lcm_tools/base/check.hpp"

namespace marco::drivers {
namespace {

// With fewer readings, or over a shorter time, the slope shows jitter more than drift.
constexpr std::size_t kMinForDrift = 20;
constexpr double kMinSpanS = 2.0;

}  // namespace

Utime ClockFilter::update(double device_s, Utime arrival) {
  if (readings_.empty()) origin_ = arrival;
  require(readings_.empty() || device_s >= readings_.back().device_s,
          "a device's clock went backwards");
  const double arrival_s = (arrival - origin_).seconds();
  if (!readings_.empty() && device_s == readings_.back().device_s) {
    readings_.back().arrival_s = std::min(readings_.back().arrival_s, arrival_s);
  } else {
    readings_.push_back({device_s, arrival_s});
  }
  if (readings_.size() > window_) readings_.pop_front();
  fit();
  const double on_line_s = anchor_s_ + slope_ * (device_s - anchor_device_s_);
  Reading& last = readings_.back();
  last.delay_s = std::max(0.0, last.arrival_s - on_line_s);
  return std::min(arrival, origin_ + Duration::from_seconds(on_line_s));
}

void ClockFilter::fit() {
  std::vector<const Reading*> hull;
  double middle_s = 0.0;
  for (const Reading& reading : readings_) {
    middle_s += reading.device_s / static_cast<double>(readings_.size());
    while (hull.size() >= 2) {
      const Reading& a = *hull[hull.size() - 2];
      const Reading& b = *hull.back();
      const double turn = (b.device_s - a.device_s) * (reading.arrival_s - a.arrival_s) -
                          (b.arrival_s - a.arrival_s) * (reading.device_s - a.device_s);
      if (turn > 0.0) break;
      hull.pop_back();
    }
    hull.push_back(&reading);
  }
  slope_ = 1.0;
  const double span_s = readings_.back().device_s - readings_.front().device_s;
  if (readings_.size() >= kMinForDrift && span_s >= kMinSpanS) {
    for (std::size_t i = 1; i < hull.size(); ++i) {
      if (hull[i]->device_s < middle_s && i + 1 < hull.size()) continue;
      slope_ = (hull[i]->arrival_s - hull[i - 1]->arrival_s) /
               (hull[i]->device_s - hull[i - 1]->device_s);
      break;
    }
    slope_ = std::clamp(slope_, 1.0 - max_drift_, 1.0 + max_drift_);
  }
  // The line of this slope that touches the arrivals from below.
  double lowest_s = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const double above_s = hull[i]->arrival_s - slope_ * (hull[i]->device_s - middle_s);
    lowest_s = i == 0 ? above_s : std::min(lowest_s, above_s);
  }
  anchor_device_s_ = middle_s;
  anchor_s_ = lowest_s;
}

double ClockFilter::jitter_s() const {
  if (readings_.empty()) return 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (const Reading& reading : readings_) {
    sum += reading.delay_s;
    squares += reading.delay_s * reading.delay_s;
  }
  const double count = static_cast<double>(readings_.size());
  return std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count)));
}

double ClockFilter::max_delay_s() const {
  double most = 0.0;
  for (const Reading& reading : readings_) most = std::max(most, reading.delay_s);
  return most;
}

void ClockFilter::reset() {
  readings_.clear();
  slope_ = 1.0;
}

}  // namespace marco::drivers
