#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace marco::logs {

/// Keeps an even pick of a stream of values in constant memory: every 2^k-th, k growing as the
/// stream does. The same stream gives the same pick.
template <class Value>
class Decimated {
 public:
  void add(const Value& value) {
    if ((count_++ & mask_) != 0) return;
    if (values_.size() == kCapacity) {
      for (std::size_t i = 0; 2 * i < values_.size(); ++i) values_[i] = values_[2 * i];
      values_.resize(kCapacity / 2);
      const bool dropped = ((count_ - 1) & (2 * mask_ + 1)) != 0;
      mask_ = 2 * mask_ + 1;
      if (dropped) return;
    }
    values_.push_back(value);
  }
  const std::vector<Value>& values() const { return values_; }

 private:
  static constexpr std::size_t kCapacity = 1024;
  std::vector<Value> values_;
  uint64_t count_ = 0;
  uint64_t mask_ = 0;
};

/// The value of which `part` (0..1) of the others are smaller. @param values not empty
template <class Value>
Value quantile(std::vector<Value> values, double part) {
  const auto place = values.begin() + std::lround(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace marco::logs
