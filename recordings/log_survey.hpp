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
  int64_t shift_us = 0;  ///< added to its stamps it gives the laser's clock, at its first stamp
  double drift = 0.0;    ///< by which that grows, a second
  int64_t first_us = 0;  ///< its first stamp
  std::optional<int64_t> offset_us;  ///< median of event time - utime, where the times are valid
  int64_t complete_us = 0;           ///< from its stamp to when it is measured, of a laser's scan
};

/// Results of a first pass over an LCM log.
struct LogSurvey {
  std::map<std::string, LoggedChannel> channels;
  std::string lidar_channel;  ///< the first laser's: its clock is the log's
  bool has_sensor_info = false;
  int64_t pictures = 0;              ///< events of bot_core.image_t
  bool stamps_are_unusable = false;  ///< they stand still or have another unit than microseconds
  std::set<int64_t> stopped_us;      ///< event times that stood still while the stamps advanced
  std::vector<std::string> notes;    ///< clocks that disagree, for the report
};

/// Finds invalid event times: those that stand still while the messages' stamps advance (a logger
/// without a clock), and those that jump back by more than ten seconds or ahead by more than an
/// hour.
class EventTimes {
 public:
  /// In the order of the log. @param utime  of the event's message, where it has one
  /// @returns false: as far as is known by now, its time is invalid.
  bool take(const files::LogEvent& event, std::optional<int64_t> utime);
  const std::set<int64_t>& stopped_us() const { return stopped_us_; }
  /// Events with an invalid time.
  int64_t invalid() const { return invalid_; }

 private:
  std::optional<int64_t> now_us_;
  bool jumped_ = false;                         ///< to this time
  int64_t events_now_ = 0;                      ///< in a row, of the same time
  std::map<std::string, int64_t> first_stamp_;  ///< of each channel among these
  std::set<int64_t> stopped_us_;
  int64_t invalid_ = 0;
};

/// Reads the whole log once. @throws std::invalid_argument naming file and remedy when it holds no
/// event, or no laser.
LogSurvey survey_log(const std::string& path, const ForeignTable& table);

}  // namespace marco
