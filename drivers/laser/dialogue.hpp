#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers {

/// Driver of a laser that is asked and answers, phase after phase, until its scans come. A derived
/// class knows the phases: what is asked, what an answer means, and what follows when none came.
/// Parser: push(), next(), garbage_bytes(), perhaps bad_checksums(). Scans: counts(), take_scans().
template <class Parser, class Scans>
class Dialogue : public LaserDriver {
 public:
  std::vector<ArrivedScan> step() final {
    using std::chrono::microseconds;
    constexpr microseconds kStep{50'000};
    const microseconds rest((deadline_ - clock_()).us);
    uint8_t buffer[16'384];
    const std::size_t count =
        stream_.read(buffer, asks() ? std::clamp(rest, microseconds(0), kStep) : kStep);
    const Utime arrival = clock_();
    if (is_receiving()) {
      parser_.push({buffer, count});
      while (const auto answer = parser_.next()) on_answer(*answer, arrival);
    }
    if (asks() ? clock_() >= deadline_ : clock_() > deadline_) on_timeout();
    scans_.counts().garbage_bytes = parser_.garbage_bytes();
    if constexpr (requires { parser_.bad_checksums(); }) {
      const int64_t bad = parser_.bad_checksums();
      if (bad > 0) scans_.counts().drops["bad_checksum"] = bad;
    }
    return scans_.take_scans();
  }
  const LaserCounts& counts() const final { return scans_.counts(); }

 protected:
  /// @param stream  outlives the driver.
  template <class... Timing>
  Dialogue(ByteStream& stream, Clock clock, const Timing&... timing)
      : stream_(stream), clock_(std::move(clock)), scans_(timing...) {}

  void set_speed(int baud) {
    stream_.set_line({baud, Parity::none});
    stream_.discard_input();
  }
  void wait(Duration time) { deadline_ = clock_() + time; }

  ByteStream& stream_;
  Clock clock_;
  Parser parser_;
  Scans scans_;
  int tries_ = 0;   ///< in this phase
  Utime deadline_;  ///< of the phase; while scans come, of the next one
  std::string trouble_;

 private:
  using Parsed = typename decltype(std::declval<Parser&>().next())::value_type;

  /// Whether an answer is due at the deadline. Otherwise scans come.
  virtual bool asks() const = 0;
  /// false: what comes is thrown away.
  virtual bool is_receiving() const { return true; }
  virtual void on_answer(const Parsed& answer, Utime arrival) = 0;
  virtual void on_timeout() = 0;
};

}  // namespace marco::drivers
