#include "tools/spy/statistics.hpp"

#include <algorithm>

namespace marco::spy {
namespace {

double jitter(int64_t shortest_us, int64_t longest_us) {
  return longest_us > shortest_us ? static_cast<double>(longest_us - shortest_us) * 1e-6 : 0;
}

}  // namespace

void RateMeter::add(int64_t time_us, std::size_t bytes) {
  time_us = std::clamp<int64_t>(time_us, 0, kMaxTimeUs);
  if (count_ == 0) {
    first_us_ = time_us;
  } else {
    time_us = std::max(time_us, last_us_);
  }
  Bucket& bucket = buckets_[static_cast<std::size_t>(time_us / kBucketUs % kBuckets)];
  if (bucket.number != time_us / kBucketUs) {
    bucket = {};
    bucket.number = time_us / kBucketUs;
    bucket.first_us = time_us;
  }
  if (count_ > 0) {
    last_interval_us_ = time_us - last_us_;
    shortest_us_ = std::min(shortest_us_, last_interval_us_);
    longest_us_ = std::max(longest_us_, last_interval_us_);
    bucket.shortest_us = std::min(bucket.shortest_us, last_interval_us_);
    bucket.longest_us = std::max(bucket.longest_us, last_interval_us_);
  }
  ++count_;
  ++bucket.count;
  bytes_ += static_cast<int64_t>(bytes);
  bucket.bytes += static_cast<int64_t>(bytes);
  bucket.last_us = time_us;
  last_us_ = time_us;
}

Rates RateMeter::recent(int64_t now_us) const {
  if (count_ < 2) return {};
  now_us = std::clamp<int64_t>(now_us, last_us_, kMaxTimeUs);
  Bucket window;
  window.first_us = INT64_MAX;
  for (const Bucket& bucket : buckets_) {
    if (bucket.count == 0 || bucket.number <= now_us / kBucketUs - kBuckets) continue;
    window.count += bucket.count;
    window.bytes += bucket.bytes;
    window.first_us = std::min(window.first_us, bucket.first_us);
    window.shortest_us = std::min(window.shortest_us, bucket.shortest_us);
    window.longest_us = std::max(window.longest_us, bucket.longest_us);
  }
  Rates rates;
  rates.jitter_s = jitter(window.shortest_us, window.longest_us);
  const double span_s = static_cast<double>(last_us_ - window.first_us) * 1e-6;
  if (window.count >= 3 && span_s > 0) {
    rates.hz = static_cast<double>(window.count - 1) / span_s;
    rates.bytes_per_s =
        rates.hz * static_cast<double>(window.bytes) / static_cast<double>(window.count);
    return rates;
  }
  const int64_t interval_us = std::max(last_interval_us_, now_us - last_us_);
  if (interval_us > 0) rates.hz = 1e6 / static_cast<double>(interval_us);
  rates.bytes_per_s = rates.hz * static_cast<double>(bytes_) / static_cast<double>(count_);
  return rates;
}

Rates RateMeter::overall() const {
  Rates rates;
  if (count_ < 2 || last_us_ <= first_us_) return rates;
  rates.hz = static_cast<double>(count_ - 1) * 1e6 / static_cast<double>(last_us_ - first_us_);
  rates.bytes_per_s = rates.hz * static_cast<double>(bytes_) / static_cast<double>(count_);
  rates.jitter_s = jitter(shortest_us_, longest_us_);
  return rates;
}

}  // namespace marco::spy
