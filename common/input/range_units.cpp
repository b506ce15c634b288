#include "common/input/range_units.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/input/input_gates.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco {
namespace {

// Scans that are looked at, one to four seconds; memory is bounded for lasers of many beams.
constexpr int kScans = 20;
constexpr std::size_t kMostRanges = 100'000;
constexpr double kCodePart = 0.02;  // of all ranges have one value: a code, not a distance
using namespace input_gates;

// Without those that repeat themselves; 0 when that is nearly all.
double median_of_returns(std::vector<float> ranges_m) {
  std::sort(ranges_m.begin(), ranges_m.end());
  const auto most = static_cast<std::ptrdiff_t>(kCodePart * static_cast<double>(ranges_m.size()));
  std::vector<float> returns_m;
  for (auto range = ranges_m.begin(); range != ranges_m.end();) {
    const auto other = std::upper_bound(range, ranges_m.end(), *range);
    if (other - range <= std::max<std::ptrdiff_t>(1, most)) {
      returns_m.insert(returns_m.end(), range, other);
    }
    range = other;
  }
  constexpr double kFewestPart = 0.1;  // of fewer returns, as outdoors, nothing is concluded
  if (static_cast<double>(returns_m.size()) < kFewestPart * static_cast<double>(ranges_m.size())) {
    return 0.0;
  }
  return returns_m.empty() ? 0.0 : static_cast<double>(returns_m[returns_m.size() / 2]);
}

}  // namespace

std::optional<std::string> RangeUnits::look(const LaserScan& scan) {
  Channel& channel = channels_[scan.channel];
  if (channel.scans >= kScans) return channel.verdict;
  for (const float range_m : scan.ranges_m) {
    if (std::isfinite(range_m) && range_m > 0.0F && channel.ranges_m.size() < kMostRanges) {
      channel.ranges_m.push_back(range_m);
    }
  }
  if (++channel.scans < kScans) return std::nullopt;
  const double median_m = median_of_returns(std::exchange(channel.ranges_m, {}));
  if (median_m <= kNobodySeesM) return std::nullopt;
  const bool millimetres = median_m >= kMillimetresFromM;
  channel.verdict = format(
      "half the ranges of %s are beyond %.0f m, where no laser sees: are these %s? "
      "Marco takes metres: divide the ranges by %d",
      scan.channel.substr(0, 60).c_str(), median_m, millimetres ? "millimetres" : "centimetres",
      millimetres ? 1000 : 100);
  return channel.verdict;
}

}  // namespace marco
