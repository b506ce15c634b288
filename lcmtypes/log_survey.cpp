#include "lcmtypes/log_survey.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <regex>

#include "common/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace marco {
namespace {

using files::LogEvent;

constexpr double kClocksDisagreeS = 0.5;
constexpr std::size_t kEnoughOffsets = 2000;

using Offsets = std::map<std::string, std::vector<int64_t>>;  // of a channel: event time - utime

bool is_own_channel(const std::string& name) {
  return name == channels::kSensorInfo || name == channels::kOdometry || name == channels::kImu ||
         name == channels::kPanTiltState || name == channels::kTruePose ||
         name.rfind(channels::kLidar, 0) == 0;
}

LoggedChannel::Meaning classify(const LogEvent& event,
                                const ForeignTable& table,
                                bool has_sensor_info,
                                ForeignChannel& foreign) {
  const std::string fingerprint = fingerprint_of(event);
  bool decodes = false;
  try {
    decodes =
        is_own_channel(event.channel) && decode_sample(event.channel, event.bytes).has_value();
  } catch (const std::invalid_argument&) {
    decodes = true;  // ours, but a bad one
  }
  for (const ForeignChannel& entry : table.channels) {
    if (entry.fingerprint != fingerprint) continue;
    if (!std::regex_match(event.channel, std::regex(entry.channel, std::regex::extended))) continue;
    // A laser on our own channel name is ours where the log says how it sits, else by the table.
    if (decodes && (has_sensor_info || entry.meaning != "lidar"))
      return LoggedChannel::Meaning::ours;
    foreign = entry;
    if (entry.meaning == "lidar") return LoggedChannel::Meaning::lidar;
    if (entry.meaning == "odometry") return LoggedChannel::Meaning::odometry;
    if (entry.meaning == "encoders") return LoggedChannel::Meaning::encoders;
    if (entry.meaning == "true_pose") return LoggedChannel::Meaning::true_pose;
    return LoggedChannel::Meaning::passed_by;
  }
  return decodes ? LoggedChannel::Meaning::ours : LoggedChannel::Meaning::passed_by;
}

void compare_clocks(LogSurvey& survey, Offsets& offsets) {
  for (auto& [name, offsets_us] : offsets) {
    if (offsets_us.empty()) continue;
    const auto middle = offsets_us.begin() + static_cast<std::ptrdiff_t>(offsets_us.size() / 2);
    std::nth_element(offsets_us.begin(), middle, offsets_us.end());
    survey.channels.at(name).offset_us = *middle;
  }
  const int64_t lidar_offset_us = survey.channels.at(survey.lidar_channel).offset_us;
  for (auto& [name, channel] : survey.channels) {
    if (channel.meaning == LoggedChannel::Meaning::passed_by) continue;
    const int64_t difference_us = channel.offset_us - lidar_offset_us;
    if (std::abs(static_cast<double>(difference_us)) * 1e-6 < kClocksDisagreeS) continue;
    channel.shift_us = difference_us;
    char note[200];
    std::snprintf(note, sizeof note,
                  "the clocks of %s and %s differ by %.1f s: taken by event time", name.c_str(),
                  survey.lidar_channel.c_str(), static_cast<double>(difference_us) * 1e-6);
    survey.notes.emplace_back(note);
  }
}

}  // namespace

std::string fingerprint_of(const LogEvent& event) {
  if (event.bytes.size() < 8) return "";
  char text[17];
  for (std::size_t i = 0; i < 8; ++i) std::snprintf(text + 2 * i, 3, "%02x", event.bytes[i]);
  return text;
}

// `utime` is the first field of every type we read.
std::optional<int64_t> utime_of(const LogEvent& event) {
  if (event.bytes.size() < 16) return std::nullopt;
  uint64_t value = 0;
  for (std::size_t i = 8; i < 16; ++i) value = (value << 8U) | event.bytes[i];
  return static_cast<int64_t>(value);
}

LogSurvey survey_log(const std::string& path, const ForeignTable& table) {
  LogSurvey survey;
  Offsets offsets;
  files::EventLogReader log(path);
  int64_t events = 0;
  while (const std::optional<LogEvent> event = log.next()) {
    ++events;
    const auto [entry, is_new] = survey.channels.try_emplace(event->channel);
    LoggedChannel& channel = entry->second;
    ++channel.count;
    if (event->channel == channels::kSensorInfo) survey.has_sensor_info = true;
    if (is_new || channel.meaning == LoggedChannel::Meaning::passed_by) {
      channel.fingerprint = fingerprint_of(*event);
      channel.meaning = classify(*event, table, survey.has_sensor_info, channel.foreign);
    }
    const auto utime = utime_of(*event);
    std::vector<int64_t>& offsets_us = offsets[event->channel];
    if (utime && channel.meaning != LoggedChannel::Meaning::passed_by &&
        offsets_us.size() < kEnoughOffsets) {
      offsets_us.push_back(static_cast<int64_t>(static_cast<uint64_t>(event->event_time.us) -
                                                static_cast<uint64_t>(*utime)));
    }
    const bool laser = channel.meaning == LoggedChannel::Meaning::lidar ||
                       (channel.meaning == LoggedChannel::Meaning::ours &&
                        event->channel.rfind(channels::kLidar, 0) == 0);
    if (laser && survey.lidar_channel.empty()) survey.lidar_channel = event->channel;
  }
  require(events > 0, path + ": holds no whole LCM event");
  if (survey.lidar_channel.empty()) {
    std::string seen;
    for (const auto& [name, channel] : survey.channels) {
      seen += (seen.empty() ? "" : ", ") + name + " (" + channel.fingerprint + ")";
    }
    throw std::invalid_argument(path + ": no laser among its channels: " + seen +
                                ". Say what they mean in a copy of config/foreign.toml and give it "
                                "with --foreign");
  }
  compare_clocks(survey, offsets);
  return survey;
}

}  // namespace marco
