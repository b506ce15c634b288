#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/files/event_log.hpp"
#include "recordings/foreign.hpp"

namespace marco {

/// What is known of a channel of a log.
struct LoggedChannel {
  enum class Meaning { ours, lidar, odometry, encoders, true_pose, passed_by };
  Meaning meaning = Meaning::passed_by;
  ForeignChannel foreign;
  std::string fingerprint;  ///< of its first event, 16 hexadecimal digits
  int64_t count = 0;
  int64_t shift_us = 0;              ///< to be added to its stamps, for the laser's clock
  std::optional<int64_t> offset_us;  ///< event time less utime, median of those that say something
};

/// What a first reading of an LCM log tells, before any of it is used.
struct LogSurvey {
  std::map<std::string, LoggedChannel> channels;
  std::string lidar_channel;  ///< the first laser's: its clock is the log's
  bool has_sensor_info = false;
  std::set<int64_t> stopped_us;    ///< event times that stood still while the stamps went on
  std::vector<std::string> notes;  ///< clocks that disagree, for a person
};

/// Tells event times that say nothing: those that stand still while the stamps of the messages go
/// on (a log that was written without a clock), and those that leap back by more than ten seconds
/// or ahead by more than an hour.
class EventTimes {
 public:
  /// In the order of the log. @param utime  of the event's message, where it has one
  /// @returns false: its time says nothing, as far as is known by now.
  bool take(const files::LogEvent& event, std::optional<int64_t> utime);
  const std::set<int64_t>& stopped_us() const { return stopped_us_; }
  /// Events whose times say nothing.
  int64_t silent() const { return silent_; }

 private:
  std::optional<int64_t> now_us_;
  bool leapt_ = false;                         ///< to this time
  int64_t events_now_ = 0;                     ///< in a row, of the same time
  std::map<std::string, int64_t> stamp_then_;  ///< of each channel's first of these
  std::set<int64_t> stopped_us_;
  int64_t silent_ = 0;
};

/// Reads the whole log once. @throws std::invalid_argument naming file and remedy when it holds no
/// event, or no laser.
LogSurvey survey_log(const std::string& path, const ForeignTable& table);

/// 16 hexadecimal digits; "" when the event is too short to have one.
std::string fingerprint_of(const files::LogEvent& event);

/// The first field of every type that is read; nothing when the event is too short to have one.
std::optional<int64_t> utime_of(const files::LogEvent& event);

}  // namespace marco
