#pragma once

#include <array>
#include <cstdint>

namespace marco::spy {

constexpr int64_t kMaxTimeUs = int64_t{1} << 60U;  ///< differences stay within 64 bits

struct Rates {
  double hz = 0;
  double bytes_per_s = 0;
  double jitter_s = 0;  ///< longest minus shortest interval between two messages
};

/// How often a channel speaks. All times [us], any values; a step back counts as no time.
class RateMeter {
 public:
  void add(int64_t time_us, std::size_t bytes);

  /// Over the last 2 s before `now_us`; of slower channels, from the last interval or the time
  /// since then if that is longer, so that a channel gone silent falls towards 0.
  Rates recent(int64_t now_us) const;
  /// From the first message to the last.
  Rates overall() const;

  int64_t count() const { return count_; }
  int64_t bytes() const { return bytes_; }
  int64_t first_us() const { return first_us_; }
  int64_t last_us() const { return last_us_; }

 private:
  static constexpr int64_t kBucketUs = 250000;
  static constexpr int64_t kBuckets = 8;
  struct Bucket {
    int64_t number = -1;  // time / kBucketUs
    int64_t count = 0;
    int64_t bytes = 0;
    int64_t first_us = 0;
    int64_t last_us = 0;
    int64_t shortest_us = INT64_MAX;
    int64_t longest_us = 0;
  };

  std::array<Bucket, kBuckets> buckets_ = {};
  int64_t count_ = 0;
  int64_t bytes_ = 0;
  int64_t first_us_ = 0;
  int64_t last_us_ = 0;
  int64_t last_interval_us_ = 0;
  int64_t shortest_us_ = INT64_MAX;
  int64_t longest_us_ = 0;
};

}  // namespace marco::spy
