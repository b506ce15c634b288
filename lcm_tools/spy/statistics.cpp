#include "lcm_tools/spy/statistics.hpp"

#include <algorithm>

namespace marco::spy {
namespace {

// 2 s less some slack: bursts each second, or each half of one, that come a little late still count
// from the pause behind an earlier one.
constexpr int64_t kWindowUs = 1'900'000;
constexpr int64_t kPauseUs = 20'000;
constexpr int64_t kClusterUs = 250'000;
constexpr int64_t kBeginningUs = 10'000'000;

int64_t bounded(int64_t time_us) { return std::clamp<int64_t>(time_us, 0, kMaxTimeUs); }

}  // namespace

void RateMeter::Pauses::add(int64_t interval_us) {
  shortest_us = std::min(shortest_us, interval_us);
  longest_us = std::max(longest_us, interval_us);
}

void RateMeter::Pauses::add(const Pauses& other) {
  shortest_us = std::min(shortest_us, other.shortest_us);
  longest_us = std::max(longest_us, other.longest_us);
}

bool RateMeter::Pauses::explain(int64_t silence_us) const {
  return 2 * silence_us <= 3 * longest_us;
}

void RateMeter::add(int64_t time_us, std::size_t bytes) {
  time_us = bounded(time_us);
  const bool is_first = count_ == 0;
  if (is_first) first_us_ = last_us_ = time_us;
  time_us = std::max(time_us, last_us_);
  const int64_t pause_us = time_us - last_us_;
  if (!is_first && last_us_ - first_us_ <= kBeginningUs && pause_us > first_pause_us_) {
    first_pause_us_ = pause_us;
    before_pause_ = {last_us_, count_, bytes_};
  }
  if (is_first || pause_us >= kPauseUs || time_us - clusters_.back().first_us >= kClusterUs) {
    clusters_.push_back({time_us, {}, {}});
    while (clusters_.size() > 1 && clusters_[1].end.time_us <= time_us - kWindowUs &&
           clusters_[1].end.count > 0) {
      clusters_.pop_front();
    }
  }
  Cluster& cluster = clusters_.back();
  if (!is_first) {
    cluster.pauses.add(pause_us);
    pauses_.add(pause_us);
  }
  ++count_;
  bytes_ += static_cast<int64_t>(bytes);
  last_us_ = time_us;
  cluster.end = {time_us, count_, bytes_};
}

// How many of the clusters ended at or before that time.
std::size_t RateMeter::clusters_until(int64_t time_us) const {
  const auto behind =
      std::partition_point(clusters_.begin(), clusters_.end(),
                           [&](const Cluster& cluster) { return cluster.end.time_us <= time_us; });
  return static_cast<std::size_t>(behind - clusters_.begin());
}

RateMeter::Pauses RateMeter::pauses_since(std::size_t cluster) const {
  Pauses result;
  for (; cluster < clusters_.size(); ++cluster) result.add(clusters_[cluster].pauses);
  return result;
}

Rates RateMeter::rates_since(const Mark& start, const Pauses& pauses) const {
  Rates rates;
  if (pauses.longest_us > pauses.shortest_us) {
    rates.jitter_s = static_cast<double>(pauses.longest_us - pauses.shortest_us) * 1e-6;
  }
  const double span_s = static_cast<double>(last_us_ - start.time_us) * 1e-6;
  if (!(span_s > 0)) return rates;
  rates.hz = static_cast<double>(count_ - start.count) / span_s;
  rates.bytes_per_s = static_cast<double>(bytes_ - start.bytes) / span_s;
  return rates;
}

// The time up to now counts; where nothing came since `start`, as if a message came now.
Rates RateMeter::silent_rates(const Mark& start, const Pauses& pauses, int64_t now_us) const {
  Rates rates = rates_since(start, pauses);
  const double span_s = static_cast<double>(now_us - start.time_us) * 1e-6;
  const int64_t count = count_ - start.count;
  rates.hz = static_cast<double>(std::max<int64_t>(1, count)) / span_s;
  rates.bytes_per_s = count > 0
                          ? static_cast<double>(bytes_ - start.bytes) / span_s
                          : rates.hz * static_cast<double>(bytes_) / static_cast<double>(count_);
  return rates;
}

Rates RateMeter::recent(int64_t now_us) const {
  if (count_ < 2) return {};
  now_us = std::max(bounded(now_us), last_us_);
  const std::size_t behind = clusters_until(last_us_ - kWindowUs);
  if (behind == 0) return overall(now_us);
  const Pauses pauses = pauses_since(behind);
  if (pauses.explain(now_us - last_us_)) return rates_since(clusters_[behind - 1].end, pauses);
  const std::size_t quiet = clusters_until(now_us - kWindowUs);
  return silent_rates(clusters_[quiet - 1].end, pauses, now_us);
}

Rates RateMeter::overall(int64_t now_us) const {
  if (count_ < 2) return {};
  now_us = std::max(bounded(now_us), last_us_);
  if (pauses_.explain(now_us - last_us_)) return rates_since(before_pause_, pauses_);
  return silent_rates({first_us_, 0, 0}, pauses_, now_us);
}

bool RateMeter::silent(int64_t now_us) const {
  if (count_ < 2) return false;
  const int64_t silence_us = std::max(bounded(now_us), last_us_) - last_us_;
  const std::size_t behind = clusters_until(last_us_ - kWindowUs);
  const Pauses pauses = behind == 0 ? pauses_ : pauses_since(behind);
  return silence_us > 1'000'000 && !pauses.explain(silence_us);
}

}  // namespace marco::spy
