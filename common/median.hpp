#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace marco {

/// Of a Gaussian around zero: its standard deviation over the median of the absolute values, the
/// inverse of the standard one's quantile at 3/4.
inline constexpr double kSigmaOfMedian = 1.4826;

/// The middle one by size, of an even number the upper of both; 0 where there is none.
/// Cost O(number).
template <class T>
T median(std::vector<T> values) {
  if (values.empty()) return T{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace marco
