#include "recordings/log_survey.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bot_core/image_t.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "recordings/clock_drift.hpp"
#include "recordings/foreign_messages.hpp"
#include "recordings/looking_through.hpp"
#include "recordings/name_list.hpp"

namespace marco {
namespace {

using files::LogEvent;

constexpr double kClocksDisagreeS = 0.5;
constexpr std::size_t kEnoughOffsets = 2000;
constexpr std::size_t kMostChannels = 10'000;  // more than any robot has

struct Offset {
  int64_t event_us;
  int64_t offset_us;  // event time - utime
};
using Offsets = std::map<std::string, std::vector<Offset>>;  // of a channel

// Unsigned: a flipped bit may make either as large as can be.
int64_t difference(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) - static_cast<uint64_t>(b));
}

bool is_own_channel(const std::string& name) {
  return name == channels::kSensorInfo || name == channels::kOdometry || name == channels::kImu ||
         name == channels::kPanTiltState || name == channels::kTruePose ||
         name == channels::kTruePoseByArrival || name.rfind(channels::kLidar, 0) == 0;
}

const std::map<std::string, LoggedChannel::Meaning> kMeanings = {
    {"lidar", LoggedChannel::Meaning::lidar},
    {"odometry", LoggedChannel::Meaning::odometry},
    {"encoders", LoggedChannel::Meaning::encoders},
    {"true_pose", LoggedChannel::Meaning::true_pose}};

LoggedChannel::Meaning classify(const LogEvent& event,
                                const ForeignTable& table,
                                bool has_sensor_info,
                                ForeignChannel& foreign) {
  const std::string fingerprint = fingerprint_in(event.bytes);
  bool decodes = false;
  try {
    decodes =
        is_own_channel(event.channel) && decode_sample(event.channel, event.bytes).has_value();
  } catch (const std::invalid_argument&) {
    decodes = true;  // ours, but a bad one
  }
  if (const ForeignChannel* entry = entry_of(table, event.channel, fingerprint)) {
    // A laser on our own channel name is ours where the log says how it sits, else by the table.
    if (decodes && (has_sensor_info || entry->meaning != "lidar"))
      return LoggedChannel::Meaning::ours;
    foreign = *entry;
    const auto meaning = kMeanings.find(entry->meaning);
    return meaning == kMeanings.end() ? LoggedChannel::Meaning::passed_by : meaning->second;
  }
  return decodes ? LoggedChannel::Meaning::ours : LoggedChannel::Meaning::passed_by;
}

// A scan is sent when its last beam is measured, whichever instant its stamp is of.
int64_t complete_us(const LogEvent& event, const ForeignChannel& foreign) {
  const auto utime = utime_in(event.bytes);
  if (!utime) return 0;
  try {
    const auto scan = std::get<LaserScan>(ForeignMessages().decode(event.bytes, foreign));
    if (scan.time_offsets_s.empty()) return 0;
    const double last_s = static_cast<double>(
        *std::max_element(scan.time_offsets_s.begin(), scan.time_offsets_s.end()));
    return difference((scan.utime + Duration::from_seconds(last_s)).us, *utime);
  } catch (const std::invalid_argument&) {
    return 0;
  }
}

// The laser's stamps by its events' times. Logs of a replay run at any speed, but not at these.
void judge_stamps(LogSurvey& survey, const Offsets& offsets) {
  constexpr std::size_t kEnough = 20;
  constexpr double kEnoughS = 2.0, kSlowest = 0.02, kFastest = 200.0;
  const auto known = offsets.find(survey.lidar_channel);
  if (known == offsets.end() || known->second.size() < kEnough) return;
  const Offset &first = known->second.front(), &last = known->second.back();
  const double events_s = 1e-6 * static_cast<double>(difference(last.event_us, first.event_us));
  const double stamps_s =
      events_s - 1e-6 * static_cast<double>(difference(last.offset_us, first.offset_us));
  if (events_s < kEnoughS) return;
  const double rate = std::abs(stamps_s) / events_s;
  if (rate > kSlowest && rate < kFastest) return;
  survey.stamps_are_unusable = true;
  char note[200];
  std::snprintf(
      note, sizeof note,
      "the stamps of %s advance by %.4g s in %.4g s: they are not microseconds. The times "
      "of the log's events are used instead",
      survey.lidar_channel.c_str(), stamps_s, events_s);
  survey.notes.emplace_back(note);
}

void compare_clocks(LogSurvey& survey, Offsets& offsets) {
  for (auto& [name, known] : offsets) {
    std::erase_if(known, [&survey](const Offset& offset) {
      return survey.stopped_us.contains(offset.event_us);
    });
    if (known.empty()) continue;
    const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end(),
                     [](const Offset& a, const Offset& b) { return a.offset_us < b.offset_us; });
    survey.channels.at(name).offset_us = middle->offset_us;
  }
  const auto delay_us = [](const LoggedChannel& channel) {
    return difference(*channel.offset_us, channel.complete_us);
  };
  const LoggedChannel& lidar = survey.channels.at(survey.lidar_channel);
  for (auto& [name, channel] : survey.channels) {
    if (channel.meaning == LoggedChannel::Meaning::passed_by) continue;
    if (!channel.offset_us || !lidar.offset_us) continue;
    const int64_t difference_us = difference(delay_us(channel), delay_us(lidar));
    if (std::abs(static_cast<double>(difference_us)) * 1e-6 < kClocksDisagreeS) continue;
    channel.shift_us = difference_us;
    char note[200];
    std::snprintf(note, sizeof note,
                  "the clocks of %s and %s differ by %.1f s: matched by event time", name.c_str(),
                  survey.lidar_channel.c_str(), static_cast<double>(difference_us) * 1e-6);
    survey.notes.emplace_back(note);
  }
}

// The laser's clock against the others': of a robot's parts it alone is not the computer's.
void compare_rates(LogSurvey& survey, const std::map<std::string, ClockDrift>& drifts) {
  constexpr double kMattersS = 0.02, kSure = 3.0;
  const auto laser = drifts.find(survey.lidar_channel);
  if (laser == drifts.end()) return;
  const auto lidar_line = laser->second.line();
  for (auto& [name, channel] : survey.channels) {
    const auto drift = drifts.find(name);
    if (channel.meaning == LoggedChannel::Meaning::passed_by || drift == drifts.end()) continue;
    const auto line = drift->second.line();
    if (!line || !lidar_line) continue;
    const double rate = line->seconds_per_s - lidar_line->seconds_per_s;
    const double apart_s = std::abs(rate) * std::min(line->span_s, lidar_line->span_s);
    if (apart_s < std::max(kMattersS, kSure * std::hypot(line->doubt_s, lidar_line->doubt_s)))
      continue;
    channel.drift = rate;
    channel.first_us = drift->second.first_us();
    char note[200];
    std::snprintf(note, sizeof note,
                  "the clocks of %s and %s drift apart by %.2f %%: matched by event time",
                  name.c_str(), survey.lidar_channel.c_str(), 100.0 * std::abs(rate));
    survey.notes.emplace_back(note);
  }
}

}  // namespace

bool EventTimes::take(const LogEvent& event, std::optional<int64_t> utime) {
  constexpr double kBackUs = 1e7, kAheadUs = 3.6e9, kStandsUs = 2e6;
  constexpr std::size_t kMostStops = 100'000;
  const int64_t time_us = event.event_time.us;
  if (now_us_ != time_us) {
    const double step_us =
        now_us_ ? static_cast<double>(time_us) - static_cast<double>(*now_us_) : 0.0;
    jumped_ = step_us < -kBackUs || step_us > kAheadUs;
    now_us_ = time_us;
    events_now_ = 0;
    first_stamp_.clear();
  }
  ++events_now_;
  if (stopped_us_.contains(time_us)) {
    ++invalid_;
    return false;
  }
  if (utime) {
    const auto [first, is_first] = first_stamp_.try_emplace(event.channel, *utime);
    const double advanced_us = static_cast<double>(*utime) - static_cast<double>(first->second);
    if (std::abs(advanced_us) > kStandsUs && stopped_us_.size() < kMostStops) {
      stopped_us_.insert(time_us);
      invalid_ += events_now_;
      return false;
    }
  }
  invalid_ += jumped_ ? 1 : 0;
  return !jumped_;
}

LogSurvey survey_log(const std::string& path, const ForeignTable& table) {
  LogSurvey survey;
  Offsets offsets;
  std::map<std::string, ClockDrift> drifts;
  EventTimes times;
  files::EventLogReader log(path);
  LookingThrough look(path);
  const auto size = static_cast<double>(std::max<int64_t>(1, log.size_bytes()));
  const auto reached = [&](int64_t at) { look.update(static_cast<double>(at) / size); };
  log.on_search(reached);
  const std::string picture = fingerprint_text(bot_core::image_t::getHash());
  int64_t events = 0;
  while (const std::optional<LogEvent> event = log.next()) {
    ++events;
    reached(log.position_bytes());
    if (survey.channels.size() == kMostChannels && !survey.channels.contains(event->channel))
      continue;
    const auto [entry, is_new] = survey.channels.try_emplace(event->channel);
    LoggedChannel& channel = entry->second;
    ++channel.count;
    if (event->channel == channels::kSensorInfo) survey.has_sensor_info = true;
    if (is_new || channel.meaning == LoggedChannel::Meaning::passed_by) {
      channel.fingerprint = fingerprint_in(event->bytes);
      survey.pictures += channel.fingerprint == picture ? 1 : 0;
      channel.meaning = classify(*event, table, survey.has_sensor_info, channel.foreign);
      if (channel.meaning == LoggedChannel::Meaning::lidar) {
        channel.complete_us = complete_us(*event, channel.foreign);
      }
    }
    const bool is_used = channel.meaning != LoggedChannel::Meaning::passed_by;
    const auto utime = is_used ? utime_in(event->bytes) : std::nullopt;
    const bool time_is_valid = times.take(*event, utime);
    std::vector<Offset>& known = offsets[event->channel];
    if (utime && time_is_valid && known.size() < kEnoughOffsets) {
      known.push_back({event->event_time.us, difference(event->event_time.us, *utime)});
    }
    if (utime && time_is_valid) drifts[event->channel].add(*utime, event->event_time.us);
    const bool laser = channel.meaning == LoggedChannel::Meaning::lidar ||
                       (channel.meaning == LoggedChannel::Meaning::ours &&
                        event->channel.rfind(channels::kLidar, 0) == 0);
    if (laser && survey.lidar_channel.empty()) survey.lidar_channel = event->channel;
  }
  require(events > 0, path + ": has no complete LCM event");
  if (survey.lidar_channel.empty()) {
    NameList seen;
    for (const auto& [name, channel] : survey.channels) {
      seen.add(name + " (" + channel.fingerprint + ")");
    }
    throw std::invalid_argument(path + ": no laser among its channels: " + seen.text() +
                                ". Describe them in a copy of config/foreign.toml and pass it with "
                                "--foreign");
  }
  if (survey.channels.size() == kMostChannels) {
    survey.notes.emplace_back("more than 10000 channels: the rest is left out");
  }
  survey.stopped_us = times.stopped_us();
  constexpr int64_t kWorthANote = 10;
  if (times.invalid() >= kWorthANote) {
    survey.notes.push_back("the event times of " + std::to_string(times.invalid()) + " of " +
                           std::to_string(events) +
                           " events stand still or jump: only the messages' own stamps are used "
                           "there");
  }
  judge_stamps(survey, offsets);
  if (survey.stamps_are_unusable) return survey;
  compare_clocks(survey, offsets);
  compare_rates(survey, drifts);
  return survey;
}

}  // namespace marco
