#pragma once

#include <optional>
#include <string>

#include "common/robot_values.hpp"
#include "common/samples.hpp"

namespace marco::teleop {

/// What a tour receives from base and pan-tilt, and whether they are still alive.
class TourLinks {
 public:
  void need_head() { needs_head_ = true; }
  void on_base(const BaseStatus& status, Utime now);
  void on_head(const PanTiltState& state, Utime now);

  /// Why the tour cannot continue; "" = no reason. Patience counts from the first call.
  std::string trouble(double patience_s, Utime now);
  /// Whether base and, if needed, pan-tilt take orders.
  bool ready() const;
  const std::optional<BaseStatus>& base() const { return base_; }
  const std::optional<PanTiltState>& head() const { return head_; }

 private:
  bool needs_head_ = false;
  std::optional<BaseStatus> base_;
  std::optional<PanTiltState> head_;
  Utime base_heard_;
  Utime head_heard_;
  Utime began_;
};

/// The scan rate of a laser, smoothed.
class ScanRate {
 public:
  void on_scan(Utime now);
  double scans_per_s(double until_known) const;

 private:
  Utime last_scan_;
  double period_s_ = 0.0;
};

}  // namespace marco::teleop
