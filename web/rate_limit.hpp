#pragma once

#include <algorithm>

namespace marco::web {

/// A bucket that fills at a constant rate: what comes above the rate in the long run is refused.
class RateLimit {
 public:
  RateLimit(double per_s, double most) : per_s_(per_s), most_(most), left_(most) {}

  /// @param now_s  any clock that never steps back. @returns whether `amount` is within the limit.
  bool take(double now_s, double amount = 1.0) {
    left_ = std::min(most_, left_ + per_s_ * std::max(0.0, now_s - at_s_));
    at_s_ = now_s;
    if (left_ < amount) return false;
    left_ -= amount;
    return true;
  }

 private:
  double per_s_, most_, left_, at_s_ = 0.0;
};

}  // namespace marco::web
