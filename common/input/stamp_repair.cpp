#include "common/input/stamp_repair.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/input/input_gates.hpp"

namespace marco {
namespace {

using input_gates::kJitter;
using input_gates::kStalled;
constexpr double kStalledS = 0.005;    // between two stamps: what no laser can do
constexpr double kClockWasSet = 10.0;  // periods; no logger stalls for so long
constexpr int kMostRepaired = 8;       // in a row: more, and the beat itself is wrong
constexpr int kNewBeat = 2;            // steps of one period in a row
constexpr double kFollow = 0.2;        // of a deviation within the jitter

}  // namespace

Utime StampRepair::repair(Utime stamp) {
  const std::optional<Utime> before = std::exchange(raw_, stamp);
  if (!before) return beat_ = believed_ = stamp;
  const double step_s = (stamp - *before).seconds();
  const double period_s = period_s_;
  const Utime predicted = beat_ + Duration::from_seconds(period_s);
  const double late_s = (stamp - predicted).seconds();
  regular_ = std::abs(step_s - period_s) <= kJitter * period_s ? regular_ + 1 : 0;
  const double lag_s = std::clamp(-late_s, 0.0, kClockWasSet * period_s);
  off_beat_ = period_s > 0.0 ? std::abs(lag_s - std::exchange(lag_s_, lag_s)) / period_s : 0.0;
  const bool early = late_s < -kJitter * period_s && late_s > -kClockWasSet * period_s;
  // Where scans are missing one may come long before the next is expected, but not at once.
  const bool stalls = repaired_ > 0 || step_s < std::min(kStalled * period_s, kStalledS);
  if (period_s > 0.0 && early && stalls && repaired_ < kMostRepaired && regular_ < kNewBeat) {
    ++repaired_;
    return beat_ = predicted;
  }
  // Over a stall the mean: what its scans' stamps lack, the next one makes up for.
  learn_period((stamp - believed_).seconds() / (1 + repaired_));
  believed_ = stamp;
  repaired_ = 0;
  const bool near = std::abs(late_s) <= kJitter * period_s;
  beat_ = near ? predicted + Duration::from_seconds(kFollow * late_s) : stamp;
  return stamp;
}

void StampRepair::learn_period(double measured_s) {
  // The mean of the first few; then the median of a stream, by small steps towards each value
  // (Tierney 1983), and smaller ones where it is near: jitter must not make the period err by more
  // than the stamps do.
  constexpr int kFirst = 8;
  constexpr double kMedianStep = 0.05, kPartOfWay = 0.5;
  if (periods_ < kFirst) {
    if (measured_s > 0.0) period_s_ += (measured_s - period_s_) / ++periods_;
    return;
  }
  const double most_s = kMedianStep * period_s_;
  period_s_ += std::clamp(kPartOfWay * (measured_s - period_s_), -most_s, most_s);
}

}  // namespace marco
