#pragma once

#include <cstdint>
#include <optional>

#include "lcm_tools/base/utime.hpp"

namespace marco {

/// Repairs the stamps of one laser's scans. Where a logger stalls, several scans get stamps nearly
/// alike, or stamps that step back: such a scan lies on the beat that is predicted from those
/// before. A stamp that is late, or near its beat, is believed as it is; so is every stamp once
/// two in a row are a period apart or eight in a row were repaired. Not thread-safe.
class StampRepair {
 public:
  /// To be called once a scan, in order of arrival.
  Utime repair(Utime stamp);
  double period_s() const { return period_s_; }
  /// By how many periods the last scan's stamp left the beat, or came back to it: odometry that was
  /// looked up by it may belong to another moment.
  double off_beat() const { return off_beat_; }

  template <class Visitor>
  void visit(Visitor& v) {
    v("raw", raw_);
    v("beat", beat_);
    v("believed", believed_);
    v("period_s", period_s_);
    v("periods", periods_);
    v("lag_s", lag_s_);
    v("off_beat", off_beat_);
    v("repaired", repaired_);
    v("regular", regular_);
  }

 private:
  void learn_period(double measured_s);

  std::optional<Utime> raw_;  ///< the last scan's stamp
  Utime beat_;                ///< where that scan lies
  Utime believed_;            ///< the last stamp that was not repaired
  double period_s_ = 0.0;     ///< running median; 0 = not known yet
  int32_t periods_ = 0;       ///< that were measured, up to a few
  double lag_s_ = 0.0;        ///< of the last scan's stamp behind the beat; 0 = none
  double off_beat_ = 0.0;
  int32_t repaired_ = 0;  ///< scans in a row
  int32_t regular_ = 0;   ///< steps of one period in a row
};

}  // namespace marco
