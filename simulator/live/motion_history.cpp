#include "simulator/live/motion_history.hpp"

#include <algorithm>

namespace marco::sim {
namespace {

constexpr int64_t kKeepUs = 1'000'000;

}  // namespace

void MotionHistory::add(const Moment& moment) {
  if (!moments_.empty() && moment.when <= moments_.back().when) return;
  moments_.push_back(moment);
  while (moments_.front().when < moment.when - Duration::from_us(kKeepUs)) moments_.pop_front();
}

MotionHistory::Moment MotionHistory::at(Utime when) const {
  if (moments_.empty()) return {};
  const auto after = std::lower_bound(moments_.begin(), moments_.end(), when,
                                      [](const Moment& m, Utime t) { return m.when < t; });
  if (after == moments_.begin()) return moments_.front();
  if (after == moments_.end()) return moments_.back();
  const Moment& a = *(after - 1);
  const Moment& b = *after;
  const double part = (when - a.when).seconds() / (b.when - a.when).seconds();
  return {when, interpolate(a.world_from_robot, b.world_from_robot, part),
          a.pan_rad + part * (b.pan_rad - a.pan_rad),
          a.tilt_rad + part * (b.tilt_rad - a.tilt_rad)};
}

}  // namespace marco::sim
