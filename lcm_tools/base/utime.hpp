#pragma once

#include <compare>
#include <cstdint>

namespace marco {

/// A span of time, whole microseconds.
struct Duration {
  int64_t us = 0;

  static constexpr Duration from_seconds(double seconds) {
    const double us = seconds * 1e6;
    return {static_cast<int64_t>(us < 0 ? us - 0.5 : us + 0.5)};
  }
  static constexpr Duration from_us(int64_t us) { return {us}; }
  constexpr double seconds() const { return static_cast<double>(us) * 1e-6; }
  constexpr auto operator<=>(const Duration&) const = default;
};

/// A moment: microseconds since 1970, of measurement, never of arrival. A struct, so that a double
/// of seconds does not compile in its place (Cartographer's common/time.h).
struct Utime {
  int64_t us = 0;

  static constexpr Utime from_us(int64_t us) { return {us}; }
  static constexpr Utime from_seconds(double seconds) {
    return {Duration::from_seconds(seconds).us};
  }
  constexpr double seconds() const { return static_cast<double>(us) * 1e-6; }
  constexpr auto operator<=>(const Utime&) const = default;
};

constexpr Duration operator-(Utime a, Utime b) { return {a.us - b.us}; }
constexpr Utime operator+(Utime a, Duration d) { return {a.us + d.us}; }
constexpr Utime operator-(Utime a, Duration d) { return {a.us - d.us}; }
constexpr Duration operator+(Duration a, Duration b) { return {a.us + b.us}; }
constexpr Duration operator-(Duration a, Duration b) { return {a.us - b.us}; }

}  // namespace marco
