#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>

#include "lcm_tools/base/utime.hpp"

namespace marco {

/// Notices a second sender on a laser's channel: scans then come much faster than before, for five
/// seconds and more. Counts by their stamps, over two seconds. Not thread-safe.
class RateWatch {
 public:
  /// Counts a scan. @returns whether its channel has just become too fast; once until it is as slow
  /// as before.
  bool is_new_sender(const std::string& channel, Utime stamp);
  /// "LIDAR: scans at 20 Hz instead of 10 Hz: is there a second sender?" of each such channel now;
  /// "" = of none.
  std::string notice() const;
  void clear() { channels_.clear(); }

 private:
  struct Channel {
    std::deque<Utime> stamps;  ///< of the last two seconds
    double usual_hz = 0.0;     ///< 0 = not known yet
    double hz = 0.0;
    std::optional<Utime> fast_since;
    bool too_fast = false;
  };
  std::map<std::string, Channel> channels_;
};

}  // namespace marco
