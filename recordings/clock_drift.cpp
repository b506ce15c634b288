#include "recordings/clock_drift.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace marco {

void ClockDrift::add(int64_t utime_us, int64_t event_us) {
  // Unsigned: a flipped bit may make either as large as can be.
  const auto difference = [](int64_t a, int64_t b) {
    return static_cast<int64_t>(static_cast<uint64_t>(a) - static_cast<uint64_t>(b));
  };
  const int64_t delay_us = difference(event_us, utime_us);
  if (least_.empty()) {
    first_us_ = utime_us;
    first_delay_us_ = delay_us;
  }
  const Delay now{1e-6 * static_cast<double>(difference(utime_us, first_us_)),
                  1e-6 * static_cast<double>(difference(delay_us, first_delay_us_))};
  // A clock that was set is another clock: its delays tell nothing of the first one's.
  constexpr double kMostS = 1e5, kWasSetS = 1.0;
  if (now.at_s < 0.0 || now.at_s > kMostS) return;
  if (!least_.empty() && std::abs(now.delay_s - least_.back().delay_s) > kWasSetS) return;
  const bool new_second = least_.empty() || std::floor(now.at_s) > std::floor(least_.back().at_s);
  if (new_second) {
    least_.push_back(now);
  } else if (now.delay_s < least_.back().delay_s && now.at_s >= least_.back().at_s) {
    least_.back() = now;
  }
}

double ClockDrift::slope_of(const std::vector<Delay>& delays) {
  const auto slope = [](const Delay& a, const Delay& b) {
    return (b.delay_s - a.delay_s) / (b.at_s - a.at_s);
  };
  std::vector<Delay> hull;  // lower; Andrew's monotone chain
  double mean_s = 0.0;
  for (const Delay& next : delays) {
    mean_s += next.at_s / static_cast<double>(delays.size());
    while (hull.size() > 1 && slope(hull[hull.size() - 2], hull.back()) >= slope(hull.back(), next))
      hull.pop_back();
    hull.push_back(next);
  }
  std::size_t end = 1;
  while (end + 1 < hull.size() && hull[end].at_s < mean_s) ++end;
  return slope(hull[end - 1], hull[end]);
}

std::optional<ClockDrift::Line> ClockDrift::line() const {
  constexpr std::size_t kFewest = 10;
  if (least_.size() < kFewest) return std::nullopt;
  const auto middle = least_.begin() + static_cast<std::ptrdiff_t>(least_.size() / 2);
  const double first = slope_of({least_.begin(), middle}),
               second = slope_of({middle, least_.end()});
  Line line;
  line.seconds_per_s = slope_of(least_);
  line.span_s = least_.back().at_s - least_.front().at_s;
  line.doubt_s = line.span_s * std::max(std::abs(first - line.seconds_per_s),
                                        std::abs(second - line.seconds_per_s));
  return line;
}

}  // namespace marco
