#pragma once

#include <cstddef>
#include <vector>

namespace marco::drivers {

/// The baud rates at which a device may listen, tried one after another until it answers.
class BaudSearch {
 public:
  /// @param wanted  tried first. @param others  tried after it, in this order.
  BaudSearch(int wanted, const std::vector<int>& others);

  int current() const { return rates_[index_]; }
  /// @returns the rate to try now: the first one after construction or restart().
  int next();
  /// The search starts over at the first rate.
  void restart();
  /// Drops a rate that the port cannot do, and restarts. @returns false when none is left.
  bool drop_current();

 private:
  std::vector<int> rates_;
  std::size_t index_ = 0;
  bool started_ = false;
};

}  // namespace marco::drivers
