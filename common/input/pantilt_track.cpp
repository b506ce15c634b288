#include "common/input/pantilt_track.hpp"

#include <algorithm>
#include <cmath>

namespace marco {
namespace {

// States: 50 s of a pan-tilt that reports at 100 Hz, longer than a scan may wait.
constexpr std::size_t kCapacity = 5000;
// 0.1 degrees; less is its jitter at rest.
constexpr double kSameAngleRad = 0.002;

PanTiltAngles between(const PanTiltState& a, const PanTiltState& b, double part) {
  return {a.pan_rad + part * normalize_angle(b.pan_rad - a.pan_rad),
          a.tilt_rad + part * (b.tilt_rad - a.tilt_rad)};
}

}  // namespace

bool PanTiltTrack::add(const PanTiltState& state) {
  const bool plausible = states_.empty() || state.utime > states_.back().utime;
  while (!states_.empty() && states_.back().utime >= state.utime) states_.pop_back();
  states_.push_back(state);
  if (states_.size() > kCapacity) states_.pop_front();
  return plausible;
}

std::optional<PanTiltAngles> PanTiltTrack::at(Utime utime) const {
  if (states_.empty() || utime < states_.front().utime) return std::nullopt;
  const auto after =
      std::upper_bound(states_.begin(), states_.end(), utime,
                       [](Utime moment, const PanTiltState& s) { return moment < s.utime; });
  const PanTiltState& before = *std::prev(after);
  if (before.utime == utime) return PanTiltAngles{before.pan_rad, before.tilt_rad};
  if (after != states_.end()) {
    const double gap_s = (after->utime - before.utime).seconds();
    const bool same = std::abs(normalize_angle(after->pan_rad - before.pan_rad)) < kSameAngleRad &&
                      std::abs(after->tilt_rad - before.tilt_rad) < kSameAngleRad;
    if (gap_s > max_gap_.seconds() && !same) return std::nullopt;
    return between(before, *after, (utime - before.utime).seconds() / gap_s);
  }
  const double beyond_s = (utime - before.utime).seconds();
  if (beyond_s > reach_.seconds()) return std::nullopt;
  if (states_.size() < 2) return PanTiltAngles{before.pan_rad, before.tilt_rad};
  const PanTiltState& earlier = states_[states_.size() - 2];
  const double step_s = (before.utime - earlier.utime).seconds();
  if (step_s > max_gap_.seconds()) return PanTiltAngles{before.pan_rad, before.tilt_rad};
  return between(earlier, before, 1.0 + beyond_s / step_s);
}

}  // namespace marco
