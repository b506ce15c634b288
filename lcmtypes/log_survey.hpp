#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/files/event_log.hpp"
#include "lcmtypes/foreign.hpp"

namespace marco {

/// What is known of a channel of a log.
struct LoggedChannel {
  enum class Meaning { ours, lidar, odometry, encoders, true_pose, passed_by };
  Meaning meaning = Meaning::passed_by;
  ForeignChannel foreign;
  std::string fingerprint;  ///< of its first event, 16 hexadecimal digits
  int64_t count = 0;
  int64_t shift_us = 0;   ///< to be added to its stamps, for the laser's clock
  int64_t offset_us = 0;  ///< event time less utime, median
};

/// What a first reading of an LCM log tells, before any of it is used.
struct LogSurvey {
  std::map<std::string, LoggedChannel> channels;
  std::string lidar_channel;  ///< the first laser's: its clock is the log's
  bool has_sensor_info = false;
  std::vector<std::string> notes;  ///< clocks that disagree, for a person
};

/// Reads the whole log once. @throws std::invalid_argument naming file and remedy when it holds no
/// event, or no laser.
LogSurvey survey_log(const std::string& path, const ForeignTable& table);

/// 16 hexadecimal digits; "" when the event is too short to have one.
std::string fingerprint_of(const files::LogEvent& event);

/// The first field of every type that is read; nothing when the event is too short to have one.
std::optional<int64_t> utime_of(const files::LogEvent& event);

}  // namespace marco
