#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

namespace marco::spy {

constexpr int64_t kMaxTimeUs = int64_t{1} << 60U;  ///< differences stay within 64 bits

struct Rates {
  double hz = 0;
  double bytes_per_s = 0;
  double jitter_s = 0;  ///< longest minus shortest interval between two messages
};

/// How often a channel speaks. All times [us], any values; a step back counts as no time.
///
/// A rate is the number of messages behind a moment, up to the last message, over the time between
/// the two; and that moment is a message after which a pause began. So a burst counts whole, with
/// the silence before it: ten messages at once each second are 10 Hz, two are 2 Hz. A silence half
/// as long again as the longest pause counts as time, too: the rate of a channel gone silent falls
/// to 0.
class RateMeter {
 public:
  void add(int64_t time_us, std::size_t bytes);

  /// Over the last 2 s before the last message; of slower channels over the last pause and what
  /// came after it.
  Rates recent(int64_t now_us) const;
  /// From the first message on.
  Rates overall(int64_t now_us) const;
  /// No message for longer than its pauses explain, and for more than a second.
  bool silent(int64_t now_us) const;

  int64_t count() const { return count_; }
  int64_t bytes() const { return bytes_; }
  int64_t first_us() const { return first_us_; }
  int64_t last_us() const { return last_us_; }

 private:
  // The meter as it stood behind a message.
  struct Mark {
    int64_t time_us = 0;
    int64_t count = 0;
    int64_t bytes = 0;
  };
  struct Pauses {
    int64_t shortest_us = INT64_MAX;
    int64_t longest_us = 0;
    void add(int64_t interval_us);
    void add(const Pauses& other);
    bool explain(int64_t silence_us) const;
  };
  // Messages that came closely together: no pause of 20 ms between them, and 250 ms at most.
  struct Cluster {
    int64_t first_us = 0;
    Mark end;
    Pauses pauses;  // that ended in it, the one before it too
  };
  Rates rates_since(const Mark& start, const Pauses& pauses) const;
  Rates silent_rates(const Mark& start, const Pauses& pauses, int64_t now_us) const;
  std::size_t clusters_until(int64_t time_us) const;
  Pauses pauses_since(std::size_t cluster) const;

  std::deque<Cluster> clusters_;  // those of the last 2 s, and one more
  Mark before_pause_;             // the longest pause of the first 10 s began behind it
  int64_t first_pause_us_ = 0;    // that pause
  Pauses pauses_;                 // all
  int64_t count_ = 0;
  int64_t bytes_ = 0;
  int64_t first_us_ = 0;
  int64_t last_us_ = 0;
};

}  // namespace marco::spy
