#include "recordings/no_return_range.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace marco {
namespace {

constexpr int64_t kFewest = 20;
constexpr double kLeastShare = 0.005;
// A pile holds this many times what walls leave in as many bins farther down.
constexpr double kPile = 10.0;
constexpr int kBinsBelow = 20;
// How far the pile's lower edge may lie from its peak, and where it ends.
constexpr int kWidest = 6;
constexpr double kEdgeShare = 0.01;

}  // namespace

void NoReturnRange::add(const std::vector<float>& ranges_m) {
  for (const double range_m : ranges_m) {
    if (!(range_m > kFirstM)) continue;
    const double bin = kBinsPerFold * std::log(range_m / kFirstM);
    if (bin < kBins) ++counts_[static_cast<std::size_t>(bin)];
  }
}

double NoReturnRange::range_m(double otherwise_m) const {
  const auto sum = [this](int first, int last) {
    return std::accumulate(counts_.begin() + std::max(first, 0), counts_.begin() + last + 1,
                           int64_t{0});
  };
  const auto fewest =
      std::max(kFewest, static_cast<int64_t>(kLeastShare * static_cast<double>(sum(0, kBins - 1))));
  int peak = kBins - 2;
  while (peak > 0 && sum(peak - 1, peak + 1) < fewest) --peak;
  if (peak == 0) return otherwise_m;
  const auto count = [this](int bin) { return counts_[static_cast<std::size_t>(bin)]; };
  while (peak > 1 && count(peak - 1) > count(peak)) --peak;
  int edge = peak;
  while (peak - edge < kWidest && edge > 0 &&
         static_cast<double>(count(edge - 1)) > kEdgeShare * static_cast<double>(count(peak))) {
    --edge;
  }
  const double walls = static_cast<double>(sum(edge - kBinsBelow, edge - 1)) / kBinsBelow;
  const double pile = static_cast<double>(sum(edge, peak + 1)) / (peak + 2 - edge);
  if (pile < kPile * walls) return otherwise_m;
  return kFirstM * std::exp((edge - 0.5) / kBinsPerFold);
}

}  // namespace marco
