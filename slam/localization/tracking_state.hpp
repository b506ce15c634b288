#pragma once

#include <optional>

#include "lcm_tools/base/utime.hpp"

namespace marco::slam {

/// When a robot that is tracked in a map counts as lost.
struct TrackingLimits {
  double contradicted_m;  ///< driven with scans that contradict the map, or ...
  double contradicted_s;  ///< ... time with such
  double unknown_m;       ///< driven where the map is silent
};

/// Whether tracking in a map can still be trusted. Not thread-safe.
class TrackingState {
 public:
  /// What a scan says of the pose that is believed.
  enum class Verdict { confirmed, says_nothing, contradicted };

  void begin(std::optional<Utime> confirmed_at);
  /// @param moves_fit  scans fit each other: they were not taken anywhere else
  /// @param moved_m  since the scan before. @returns whether the robot is lost.
  bool is_lost_after(
      Utime utime, Verdict verdict, bool moves_fit, double moved_m, const TrackingLimits& limits);
  int times_lost() const { return times_lost_; }

 private:
  std::optional<Utime> last_match_;
  double contradicted_m_ = 0.0;   ///< driven since the map last confirmed, or said nothing
  double unknown_m_ = 0.0;        ///< driven since it last confirmed
  bool tracking_broken_ = false;  ///< since it last confirmed, scans did not fit each other
  int times_lost_ = 0;
};

}  // namespace marco::slam
