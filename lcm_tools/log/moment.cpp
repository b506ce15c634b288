#include "lcm_tools/log/moment.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <optional>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::logs {
namespace {

constexpr const char* kUnderstood =
    ": not a time; write seconds (12.5), minutes (1:30), hours (1:02:03), the same with a minus "
    "for times before the end, @SECONDS since 1970, or 2016-02-04T15:33:20Z";
constexpr double kLargestS = 1e11;  // some 3000 years

std::optional<double> parse_number(std::string_view text) {
  double value = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc{} || parsed.ptr != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(value) || std::abs(value) > kLargestS) return std::nullopt;
  return value;
}

// "1:02:03.5" as seconds.
std::optional<double> parse_clock(std::string_view text) {
  double seconds = 0.0;
  for (int parts = 0; parts < 3; ++parts) {
    const std::size_t colon = text.find(':');
    const auto value = parse_number(text.substr(0, colon));
    if (!value || *value < 0.0) return std::nullopt;
    seconds = 60.0 * seconds + *value;
    if (colon == std::string_view::npos) return seconds;
    text.remove_prefix(colon + 1);
  }
  return std::nullopt;
}

std::optional<int64_t> parse_date(std::string_view text) {
  const std::string whole(text);
  std::tm date = {};
  int used = 0;
  double second = 0.0;
  if (std::sscanf(whole.c_str(), "%4d-%2d-%2dT%2d:%2d:%lfZ%n", &date.tm_year, &date.tm_mon,
                  &date.tm_mday, &date.tm_hour, &date.tm_min, &second, &used) != 6 ||
      static_cast<std::size_t>(used) != whole.size()) {
    return std::nullopt;
  }
  date.tm_year -= 1900;
  date.tm_mon -= 1;
  return static_cast<int64_t>(timegm(&date)) * 1000000 + Duration::from_seconds(second).us;
}

}  // namespace

LogSpan find_span(files::EventLogReader& reader) {
  LogSpan span;
  reader.seek(0);
  const auto first = reader.next_head();
  require(first.has_value(), "the log has no complete event");
  span.first = span.last = bounded(first->event_time);
  // From ever further before the end, until a whole event lies there.
  for (int64_t back = 64 << 10;; back *= 8) {
    reader.seek(std::max<int64_t>(0, reader.size_bytes() - back));
    bool found = false;
    while (const auto head = reader.next_head()) {
      span.last = bounded(head->event_time);
      found = true;
    }
    if (found || back >= reader.size_bytes()) break;
  }
  reader.seek(0);
  return span;
}

LogSpan span_of_log(const std::string& path) {
  files::EventLogReader reader(path);
  if (!reader.next_head()) throw NoLogError(path);
  return find_span(reader);
}

Utime Moment::in(const LogSpan& span) const {
  if (origin == Origin::epoch) return Utime::from_us(us);
  return (origin == Origin::start ? span.first : span.last) + Duration::from_us(us);
}

Moment parse_moment(std::string_view text) {
  Moment moment;
  std::optional<int64_t> us;
  const auto to_us = [](std::optional<double> seconds) -> std::optional<int64_t> {
    if (!seconds) return std::nullopt;
    return Duration::from_seconds(*seconds).us;
  };
  if (text.starts_with('@')) {
    moment.origin = Moment::Origin::epoch;
    us = to_us(parse_number(text.substr(1)));
  } else if (text.find('T') != std::string_view::npos) {
    moment.origin = Moment::Origin::epoch;
    us = parse_date(text);
  } else if (text.starts_with('-')) {
    moment.origin = Moment::Origin::end;
    us = to_us(parse_clock(text.substr(1)));
    if (us) us = -*us;
  } else {
    us = to_us(parse_clock(text));
  }
  require(us.has_value(), "'" + std::string(text) + "'" + kUnderstood);
  moment.us = *us;
  return moment;
}

TimeRange parse_range(std::string_view from, std::string_view to, const LogSpan& span) {
  TimeRange range;
  if (!from.empty()) range.from = parse_moment(from).in(span);
  if (!to.empty()) range.to = parse_moment(to).in(span);
  require(range.from < range.to, "there is nothing between " + std::string(from) + " and " +
                                     std::string(to) + " (the log spans " + to_text(span.first) +
                                     " to " + to_text(span.last) + ")");
  return range;
}

std::string to_text(Utime time) {
  std::time_t seconds = static_cast<std::time_t>(time.us / 1000000);
  int64_t micros = time.us % 1000000;
  if (micros < 0) {
    micros += 1000000;
    --seconds;
  }
  std::tm date = {};
  const bool is_date =
      gmtime_r(&seconds, &date) != nullptr && date.tm_year >= -900 && date.tm_year < 8100;
  if (!is_date) return format("@%.6f", time.seconds());
  return format("%04d-%02d-%02dT%02d:%02d:%02d.%06dZ", date.tm_year + 1900, date.tm_mon + 1,
                date.tm_mday, date.tm_hour, date.tm_min, date.tm_sec, static_cast<int>(micros));
}

}  // namespace marco::logs
