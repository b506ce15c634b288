#include "slam/process/one_source.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace marco::slam {
namespace {

constexpr double kSlowestPeriodS = 0.1;  // a slower laser's scans differ too much when it turns
constexpr double kPatienceS = 0.5;
constexpr int kFewestSteps = 10;
constexpr double kSteady = 0.1;                    // the newest step's weight in the period
constexpr double kRegular = 0.05, kOffBeat = 0.2;  // of a period

constexpr double kTurnRadPerS = 2.0, kDriveMPerS = 2.0, kNoiseM = 0.1;
constexpr double kLongestS = 0.1;  // beyond it everything would look the same
// Of a scan of the simulated lab 0.01 after the one before: 0.99 and more of 99 in 100 do; of other
// places of the same lab 0.85 at most.
constexpr double kMost = 0.9;
constexpr double kUnknownS = 0.2, kMany = 0.75;

bool has_range(float range_m) { return std::isfinite(range_m) && range_m > 0.0F; }

}  // namespace

bool looks_the_same(const LaserScan& before, const LaserScan& scan, double dt_s, double part) {
  if (before.size() != scan.size() || scan.size() == 0) return false;
  // A laser of irregular bearings is compared beam by beam, as if they were even.
  const double step_rad = std::abs(scan.bearing_step_rad);
  const double turn_beams = step_rad > 0.0 ? kTurnRadPerS * dt_s / step_rad : 0.0;
  const auto reach =
      static_cast<std::ptrdiff_t>(std::min(1.0 + turn_beams, static_cast<double>(scan.size())));
  const auto slack_m = static_cast<float>(kNoiseM + kDriveMPerS * dt_s);
  const auto count = static_cast<std::ptrdiff_t>(scan.size());
  int compared = 0, same = 0;
  for (std::ptrdiff_t beam = 0; beam < count; ++beam) {
    const float range_m = scan.ranges_m[static_cast<std::size_t>(beam)];
    if (!has_range(range_m)) continue;
    ++compared;
    float low_m = INFINITY, high_m = 0.0F;
    const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, beam - reach);
    const std::ptrdiff_t last = std::min(count - 1, beam + reach);
    for (std::ptrdiff_t near = first; near <= last; ++near) {
      const float then_m = before.ranges_m[static_cast<std::size_t>(near)];
      if (!has_range(then_m)) continue;
      low_m = std::min(low_m, then_m);
      high_m = std::max(high_m, then_m);
    }
    same += range_m >= low_m - slack_m && range_m <= high_m + slack_m ? 1 : 0;
  }
  // Of a laser that sees nothing nothing can be told.
  return compared == 0 || same >= part * compared;
}

bool OneSource::is_regular() const { return off_beat_ < kRegular; }

bool OneSource::is_known() const {
  return last_ && steps_ >= kFewestSteps && period_s_ <= kSlowestPeriodS;
}

std::size_t OneSource::patience() const {
  return static_cast<std::size_t>(std::clamp(kPatienceS / std::max(period_s_, 1e-3), 4.0, 40.0));
}

OneSource::Beat OneSource::beat_of(const LaserScan& before, const LaserScan& scan) const {
  const double since_s = (scan.utime - before.utime).seconds();
  if (period_s_ <= 0.0 || std::abs(since_s) > kPatienceS) return {0, 0.0};
  const double periods = since_s / period_s_;
  const double whole = std::max(1.0, std::round(periods));
  return {static_cast<int>(whole), std::abs(periods - whole)};
}

bool OneSource::goes_on(const LaserScan& before, const LaserScan& scan) const {
  // What its stamps do not tell may have been long ago.
  if (!is_regular()) return looks_the_same(before, scan, kUnknownS, kMany);
  const double since_s = std::abs((scan.utime - before.utime).seconds());
  return beat_of(before, scan).off <= kOffBeat &&
         looks_the_same(before, scan, std::clamp(since_s, period_s_, kLongestS), kMost);
}

void OneSource::believe(const LaserScan& scan) {
  if (last_) {
    const double step_s = std::abs((scan.utime - last_->utime).seconds());
    const Beat beat = beat_of(*last_, scan);
    // Of a gap or of a clock that was set nothing is learnt.
    if (step_s < kPatienceS) {
      ++steps_;
      const double weight = std::max(kSteady, 1.0 / steps_);
      period_s_ += weight * (step_s / std::max(beat.periods, 1) - period_s_);
      // One late stamp does not make a laser irregular.
      off_beat_ += weight * (std::min(beat.off, kOffBeat) - off_beat_);
    }
  }
  before_ = std::exchange(last_, scan);
}

bool OneSource::waits_for(const LaserScan& scan) const {
  if (waiting_.empty() || waiting_.back().size() != scan.size()) return false;
  // It looked elsewhere meanwhile: what waits lies on beats that it missed, or leads here.
  const Beat beat = beat_of(*last_, scan);
  if (!is_regular() || beat.periods == 0) {
    return looks_the_same(waiting_.back(), scan, period_s_, kMost);
  }
  if (static_cast<int>(waiting_.size()) >= beat.periods) return false;
  const bool on_beat = std::all_of(
      waiting_.begin(), waiting_.end(),
      [this](const LaserScan& missed) { return beat_of(*last_, missed).off <= kOffBeat; });
  // A busy computer stamps late; what was seen went on all the time.
  return on_beat || waiting_lead_to(scan);
}

bool OneSource::waiting_lead_to(const LaserScan& scan) const {
  const LaserScan* before = &*last_;
  const auto leads_on = [&before](const LaserScan& next) {
    const double since_s = std::abs((next.utime - before->utime).seconds());
    return looks_the_same(*std::exchange(before, &next), next, std::min(since_s, kLongestS), kMost);
  };
  return std::all_of(waiting_.begin(), waiting_.end(), leads_on) && leads_on(scan);
}

void OneSource::leave_out(const LaserScan& scan, Sorted& sorted) const {
  ++(looks_the_same(*last_, scan, kLongestS, kMost) ? sorted.off_beat : sorted.foreign);
}

bool OneSource::waiting_keep_a_rhythm() const {
  constexpr double kMostSteps = 0.8;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < waiting_.size(); ++i) {
    steps_s.push_back(std::abs((waiting_[i].utime - waiting_[i - 1].utime).seconds()));
  }
  // Where half the scans are lost a quarter of the steps is still one period.
  const auto quarter = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 4);
  std::nth_element(steps_s.begin(), quarter, steps_s.end());
  const double period_s = std::max(*quarter, 1e-3);
  const auto kept = std::count_if(steps_s.begin(), steps_s.end(), [period_s](double step_s) {
    const double periods = step_s / period_s;
    return std::abs(periods - std::max(1.0, std::round(periods))) <= kOffBeat;
  });
  return static_cast<double>(kept) >= kMostSteps * static_cast<double>(steps_s.size());
}

OneSource::Sorted OneSource::take(LaserScan scan) {
  Sorted sorted;
  bool is_ours = !is_known() || goes_on(*last_, scan);
  if (!is_ours && before_ && goes_on(*before_, scan)) {
    last_ = before_;  // the last one was another's, who is where we are
    is_ours = true;
  }
  if (!is_ours) {
    waiting_.push_back(std::move(scan));
    if (waiting_.size() <= patience()) return sorted;
    if (!is_regular() || waiting_keep_a_rhythm()) {
      sorted.own = rest();
    } else {
      leave_out(waiting_.front(), sorted);
      waiting_.pop_front();
    }
    return sorted;
  }
  if (waits_for(scan)) {
    sorted.own = rest();
  } else {
    for (const LaserScan& left_out : waiting_) leave_out(left_out, sorted);
    waiting_.clear();
  }
  believe(scan);
  sorted.own.push_back(std::move(scan));
  return sorted;
}

std::vector<LaserScan> OneSource::rest() {
  std::vector<LaserScan> all(std::make_move_iterator(waiting_.begin()),
                             std::make_move_iterator(waiting_.end()));
  waiting_.clear();
  for (const LaserScan& scan : all) believe(scan);
  return all;
}

std::vector<LaserScan> take_own(OneSource& source, LaserScan scan, process::DropCounter& drops) {
  const std::string on_channel = " on " + scan.channel;
  OneSource::Sorted sorted = source.take(std::move(scan));
  for (int i = 0; i < sorted.foreign; ++i) drops.count("a scan of another laser" + on_channel);
  for (int i = 0; i < sorted.off_beat; ++i) {
    drops.count("a scan stamped off its laser's beat" + on_channel);
  }
  return std::move(sorted.own);
}

}  // namespace marco::slam
