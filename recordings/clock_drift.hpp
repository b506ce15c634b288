#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace marco {

/// How fast the clock that stamps a channel runs away from the logger's: by the least delay between
/// a message's stamp and its event, which no queue makes smaller. Takes events in the order of the
/// log; remembers one a second.
class ClockDrift {
 public:
  void add(int64_t utime_us, int64_t event_us);

  /// A line below all delays.
  struct Line {
    double seconds_per_s = 0.0;  ///< by which the delay grows: below 0 where the clock is fast
    /// By how much the line may be off over the whole log [s]: both halves by themselves.
    double doubt_s = 0.0;
    double span_s = 0.0;  ///< from the first stamp to the last
  };
  /// Convex hull method of Zhang, Liu, Xia, "Clock synchronization algorithms for network
  /// measurements" (INFOCOM 2002): of all lines below the delays that which is nearest to them in
  /// the sum is an edge of their lower convex hull, the one above the mean stamp (Moon, Skelly,
  /// Towsley, INFOCOM 1999). @returns nothing for logs of less than 10 s
  std::optional<Line> line() const;
  int64_t first_us() const { return first_us_; }

 private:
  struct Delay {
    double at_s;     // since the first stamp
    double delay_s;  // less the first one's
  };
  static double slope_of(const std::vector<Delay>& delays);

  std::vector<Delay> least_;  // of each second
  int64_t first_us_ = 0, first_delay_us_ = 0;
};

}  // namespace marco
