#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

/// Marco's plain text protocol for home-made bases (docs/text_base.md): lines of a letter and
/// decimal numbers, with a checksum where both sides have one.
namespace marco::drivers::textbase {

inline constexpr int kBaud = 115'200;
inline constexpr int kProtocol = 1;
inline constexpr std::size_t kMaxLine = 80;  ///< characters without LF
inline constexpr int kLeastWatchdogMs = 100, kMostWatchdogMs = 2000;
inline constexpr int kLeastReportMs = 5, kMostReportMs = 1000;

/// "text*HH": the exclusive or of all before the star.
std::string with_sum(std::string_view text);
struct Body {
  std::string_view text;  ///< of the line given
  bool had_sum = false;
};
/// @returns nothing when a sum is there and wrong.
std::optional<Body> without_sum(std::string_view line);

// What a board says.

struct Hello {
  int protocol = kProtocol;
  std::string name;
  std::string firmware;
  int watchdog_ms = 0;
  bool operator==(const Hello&) const = default;
};
struct Done {
  char setting = 'W';  ///< or R
  int value_ms = 0;
  bool operator==(const Done&) const = default;
};
/// Flags of a report.
inline constexpr unsigned kMotorsOn = 1, kWatchdogStopped = 2, kLeftBumper = 4, kRightBumper = 8,
                          kEmergencyStop = 16, kFault = 32;
struct Report {
  uint32_t board_ms = 0;   ///< since it started; wraps
  int32_t left_ticks = 0;  ///< signed, ahead > 0; wraps
  int32_t right_ticks = 0;
  unsigned flags = 0;
  bool operator==(const Report&) const = default;
};
struct Battery {
  int millivolts = 0;
  bool operator==(const Battery&) const = default;
};
/// Numbers of a complaint.
inline constexpr int kBadLine = 1, kBadSum = 2, kBadValue = 3, kWatchdog = 4;
struct Complaint {
  int number = 0;
  std::string text;
  bool operator==(const Complaint&) const = default;
};
using BoardLine = std::variant<Hello, Done, Report, Battery, Complaint>;

/// @param text  without its sum.
std::optional<BoardLine> parse_board_line(std::string_view text);
std::string encode(const BoardLine& line);

// What a host says.

struct WhoAreYou {
  bool operator==(const WhoAreYou&) const = default;
};
struct Motion {
  int left_ticks_per_s = 0;  ///< ahead > 0
  int right_ticks_per_s = 0;
  bool operator==(const Motion&) const = default;
};
struct SetWatchdog {
  int ms = 0;
  bool operator==(const SetWatchdog&) const = default;
};
struct SetReports {
  int ms = 0;  ///< from a report to the next
  bool operator==(const SetReports&) const = default;
};
using HostLine = std::variant<WhoAreYou, Motion, SetWatchdog, SetReports>;

std::optional<HostLine> parse_host_line(std::string_view text);
std::string encode(const HostLine& line);

}  // namespace marco::drivers::textbase
