#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>

namespace marco::web {

/// When wrong tokens are answered: one a second of an address, four a second of all. Right ones
/// need no permission. Pure.
class GuessPace {
 public:
  /// @param now_s  any clock that never steps back. @returns how long to wait with the answer
  double wait_s(const std::string& address, double now_s) {
    constexpr double kOfAddressS = 1.0, kOfAllS = 0.25, kLongestS = 30.0;
    std::erase_if(next_s_, [&](const auto& one) { return one.second <= now_s; });
    const auto of_address = next_s_.find(address);
    const double at_s = std::max({now_s + kOfAllS, next_of_all_s_,
                                  of_address == next_s_.end() ? now_s : of_address->second});
    if (at_s > now_s + kLongestS) return kLongestS;
    next_of_all_s_ = at_s + kOfAllS;
    next_s_[address] = at_s + kOfAddressS;
    return at_s - now_s;
  }

 private:
  double next_of_all_s_ = 0.0;
  std::map<std::string, double> next_s_;  // by address
};

}  // namespace marco::web
