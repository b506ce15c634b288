#pragma once

#include <optional>

#include "drivers/base/click_odometry.hpp"
#include "drivers/textbase/codec.hpp"
#include "drivers/transport/clock_filter.hpp"

namespace marco::drivers::textbase {

/// The wheels' counters and the clock of a board's reports. Both wrap; a clock that goes back is a
/// reset.
class ReportCounter {
 public:
  struct Step {
    bool after_reset = false;  ///< the board was reset: nothing else is given
    bool plausible = true;     ///< false: more ticks than a wheel makes; they do not count
    ClickOdometry::Step clicks;
    Utime measured;  ///< by the board's clock
  };

  explicit ReportCounter(double tick_m) : tick_m_(tick_m) {}

  /// The next report is the first of a session.
  void restart();
  /// @param left  when the report left the board, by its arrival
  Step add(const Report& report, Utime left);

 private:
  double tick_m_;
  ClockFilter clock_{0.02};
  std::optional<Report> last_;
  double board_s_ = 0.0;  ///< the board's clock without wrapping
};

}  // namespace marco::drivers::textbase
