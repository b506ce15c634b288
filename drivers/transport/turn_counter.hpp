#pragma once

#include <cstdint>
#include <deque>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// Counts the turns of a mirror by the arrivals of its scans: the clock of a laser whose telegrams
/// carry no time.
class TurnCounter {
 public:
  explicit TurnCounter(double turn_s) : turn_s_(turn_s) {}

  /// What may lie between a scan and the one before it.
  enum class Gap {
    any,   ///< scans were lost: the turns are the time between the arrivals
    none,  ///< the laser sends every turn, or every n-th on a slow line (n is learnt). A late scan
           ///< is taken for delayed, unless those behind it are as late.
  };

  /// @param end  of a scan by its arrival.
  /// @returns device time for ClockFilter [s]: whole turns since the first, of nominal length. If a
  /// turn was missed after all, the count is too low until the next scan that comes in time.
  double update(Utime end, Gap gap = Gap::any);
  void reset();

 private:
  int64_t turns_since(double elapsed, Gap gap);
  void learn(int64_t turns);

  double turn_s_;
  int64_t turns_ = -1;
  int64_t usual_ = 0;          ///< turns from scan to scan; 0 = not known yet
  std::deque<int64_t> steps_;  ///< of the last scans that came in time
  double behind_ = 0.0;        ///< turns by which the last scan came late, or that were missed
  Utime last_;
};

}  // namespace marco::drivers
