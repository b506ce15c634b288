#include "slam/localization/tracking_state.hpp"

#include <cmath>

namespace marco::slam {

void TrackingState::begin(std::optional<Utime> confirmed_at) {
  last_match_ = confirmed_at;
  contradicted_m_ = unknown_m_ = 0.0;
  tracking_broken_ = false;
}

bool TrackingState::is_lost_after(
    Utime utime, Verdict verdict, bool moves_fit, double moved_m, const TrackingLimits& limits) {
  tracking_broken_ = tracking_broken_ || !moves_fit;
  if (verdict == Verdict::confirmed) {
    contradicted_m_ = unknown_m_ = 0.0;
    tracking_broken_ = false;
  }
  // Scans that do not fit each other may have been taken anywhere.
  const bool doubtful =
      verdict == Verdict::contradicted || (verdict != Verdict::confirmed && tracking_broken_);
  if (!doubtful || !last_match_) last_match_ = utime;
  unknown_m_ += moved_m;
  contradicted_m_ = doubtful ? contradicted_m_ + moved_m : 0.0;
  const double waited_s = std::abs((utime - *last_match_).seconds());
  const bool lost = contradicted_m_ > limits.contradicted_m || waited_s > limits.contradicted_s ||
                    unknown_m_ > limits.unknown_m;
  if (lost) ++times_lost_;
  return lost;
}

}  // namespace marco::slam
