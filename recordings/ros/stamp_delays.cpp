#include "recordings/ros/stamp_delays.hpp"

#include <algorithm>
#include <vector>

#include "common/median.hpp"

namespace marco::ros {

void StampDelays::add(int64_t received_ns, int64_t stamp_ns) {
  constexpr int64_t kPartNs = 5'000'000'000;
  constexpr std::size_t kMostParts = 5000;  // seven hours tell
  // As doubles: a damaged stamp may be as large as can be.
  const double delay_s = 1e-9 * (static_cast<double>(received_ns) - static_cast<double>(stamp_ns));
  if (least_s_.size() == kMostParts) return;
  const auto [least, is_new] = least_s_.try_emplace(received_ns / kPartNs, delay_s);
  least->second = std::min(least->second, delay_s);
}

double StampDelays::least_s() const {
  const auto least =
      std::min_element(least_s_.begin(), least_s_.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return least == least_s_.end() ? 0.0 : least->second;
}

double StampDelays::longer_s(const StampDelays& other) const {
  std::vector<double> longer_s;
  for (const auto& [part, delay_s] : least_s_) {
    const auto same = other.least_s_.find(part);
    if (same != other.least_s_.end()) longer_s.push_back(delay_s - same->second);
  }
  if (longer_s.empty()) return least_s() - other.least_s();
  return median(std::move(longer_s));
}

}  // namespace marco::ros
