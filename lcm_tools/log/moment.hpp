#pragma once

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "lcm_tools/base/utime.hpp"
#include "lcm_tools/files/event_log.hpp"

namespace marco::logs {

/// Damaged times can be anything: bounded so that differences of two fit 64 bits.
constexpr Utime bounded(Utime time) {
  constexpr int64_t kLimitUs = int64_t{1} << 60;
  return Utime::from_us(time.us < -kLimitUs ? -kLimitUs : time.us > kLimitUs ? kLimitUs : time.us);
}

/// First and last event of a log, by their places in the file.
struct LogSpan {
  Utime first;
  Utime last;
};

/// Reads only the two ends of the file; the reader stands at its beginning afterwards.
/// @throws std::invalid_argument when there is no whole event.
LogSpan find_span(files::EventLogReader& reader);

/// A file in which no LCM event was found.
class NoLogError : public std::invalid_argument {
 public:
  /// @param outcome  the command's result, "; nothing was written"
  explicit NoLogError(const std::string& path, const std::string& outcome = "")
      : std::invalid_argument(path + ": has no complete LCM event" + outcome),
        path_(path),
        outcome_(outcome) {}
  const std::string& path() const { return path_; }
  const std::string& outcome() const { return outcome_; }

 private:
  std::string path_;
  std::string outcome_;
};

/// As find_span, of a file. @throws NoLogError
LogSpan span_of_log(const std::string& path);

/// A moment of a log as people say it.
struct Moment {
  enum class Origin { start, end, epoch };
  Origin origin = Origin::start;
  int64_t us = 0;

  /// When that is in a log of this span.
  Utime in(const LogSpan& span) const;
};

/// "12.5" and "1:30" and "1:02:03.5" after the start, the same with "-" before the end; absolute:
/// "@1454600000.25" (seconds since 1970) and "2016-02-04T15:33:20.25Z" (UTC).
/// @throws std::invalid_argument saying what would be understood.
Moment parse_moment(std::string_view text);

/// Events from `from` up to, and not including, `to`; as it is made, every event of a log, however
/// wild its time.
struct TimeRange {
  static constexpr Utime kOpen = Utime::from_us(std::numeric_limits<int64_t>::max());
  Utime from = Utime::from_us(std::numeric_limits<int64_t>::min());
  Utime to = kOpen;

  bool contains(Utime time) const { return from <= time && (time < to || to == kOpen); }
};

/// `from` and `to` as parse_moment takes them, "" = open.
/// @throws std::invalid_argument also when there is nothing between them.
TimeRange parse_range(std::string_view from, std::string_view to, const LogSpan& span);

/// "2016-02-04T15:33:20.250000Z"; for what is no date of four digits the plain seconds.
std::string to_text(Utime time);

}  // namespace marco::logs
