#include "teleop/tour_links.hpp"

#include <algorithm>

namespace marco::teleop {

void TourLinks::on_base(const BaseStatus& status, Utime now) {
  base_ = status;
  base_heard_ = now;
}

void TourLinks::on_head(const PanTiltState& state, Utime now) {
  head_ = state;
  head_heard_ = now;
}

std::string TourLinks::trouble(double patience_s, Utime now) {
  if (began_ == Utime{}) began_ = now;
  const auto silent = [&](Utime heard) {
    return (now - std::max(heard, began_)).seconds() > patience_s;
  };
  if (silent(base_heard_)) return "no data from the base";
  if (needs_head_ && silent(head_heard_)) return "no data from the pan-tilt";
  const bool down = base_ && base_->link != BaseStatus::Link::up;
  if (down && (now - began_).seconds() > patience_s) {
    return "the base's link is lost: " + base_->note;
  }
  return "";
}

bool TourLinks::ready() const {
  return base_ && base_->link == BaseStatus::Link::up && (!needs_head_ || head_);
}

void ScanRate::on_scan(Utime now) {
  const double period_s = (now - last_scan_).seconds();
  last_scan_ = now;
  if (period_s <= 0.005 || period_s >= 2.0) return;
  period_s_ = period_s_ == 0.0 ? period_s : 0.95 * period_s_ + 0.05 * period_s;
}

double ScanRate::scans_per_s(double until_known) const {
  return period_s_ > 0.0 ? 1.0 / period_s_ : until_known;
}

}  // namespace marco::teleop
