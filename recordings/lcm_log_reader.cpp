#include "recordings/lcm_log_reader.hpp"

#include <algorithm>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/stamp.hpp"
#include "recordings/foreign_messages.hpp"
#include "recordings/log_survey.hpp"
#include "recordings/scan_bounds.hpp"

namespace marco {
namespace {

using files::LogEvent;
using Meaning = LoggedChannel::Meaning;

constexpr const char* kUndecodable = "undecodable";

// Unsigned arithmetic: a flipped bit may make either operand as large as can be.
int64_t wrapped_sum(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) + static_cast<uint64_t>(b));
}

bool within_an_hour(int64_t a_us, int64_t b_us) {
  constexpr int64_t kHourUs = 3'600'000'000;
  const auto off_us =
      static_cast<int64_t>(static_cast<uint64_t>(a_us) - static_cast<uint64_t>(b_us));
  return off_us > -kHourUs && off_us < kHourUs;
}

class LcmLogReader : public files::QueuedReader {
 public:
  LcmLogReader(const std::filesystem::path& path, const ForeignTable& table)
      : survey_(survey_log(path.string(), table)), log_(path.string()) {
    report_.format = "LCM log";
    report_.paths = {path.string()};
    report_.notes = survey_.notes;
    report_.pictures = survey_.pictures;
  }

  double progress() const override {
    return static_cast<double>(log_.position_bytes()) /
           static_cast<double>(std::max<int64_t>(1, log_.size_bytes()));
  }

 private:
  bool read_piece() override {
    const std::optional<LogEvent> event = log_.next();
    if (!event) return false;
    const auto channel = survey_.channels.find(event->channel);
    if (channel == survey_.channels.end() || channel->second.meaning == Meaning::passed_by) {
      return true;
    }
    try {
      read(*event, channel->second);
    } catch (const std::invalid_argument& fault) {
      report_.drop(fault.what(),
                   "event " + std::to_string(event->number) + " (" + event->channel + ")");
    }
    return true;
  }

  void read(const LogEvent& event, const LoggedChannel& channel) {
    require(stamp_fits(event, channel), "stamp an hour or more from its event's time");
    if (channel.meaning == Meaning::ours) {
      std::optional<Sample> sample = decode_sample(event.channel, event.bytes);
      require(sample.has_value(), kUndecodable);
      give(event, std::move(*sample), channel);
      return;
    }
    require(fingerprint_in(event.bytes) == channel.fingerprint, kUndecodable);
    if (channel.meaning == Meaning::lidar && event.channel != survey_.lidar_channel) return;
    Sample sample = messages_.decode(event.bytes, channel.foreign);
    if (const auto* scan = std::get_if<LaserScan>(&sample); scan != nullptr && !announced_) {
      announce(event.channel, messages_.info_of(*scan, channel.foreign));
    }
    give(event, std::move(sample), channel);
  }

  void announce(const std::string& logged_as, const SensorInfo& info) {
    announced_ = true;
    queue(info);
    note("%s has no SENSOR_INFO: assuming the laser at the turning centre, looking ahead",
         logged_as.c_str());
  }

  // Where the event's time jumps and the stamp does not, the event's time is wrong.
  bool stamp_fits(const LogEvent& event, const LoggedChannel& channel) {
    const auto utime = utime_in(event.bytes);
    if (!utime || survey_.stamps_are_unusable) return true;
    const auto last = last_stamp_us_.find(event.channel);
    const bool is_first = last == last_stamp_us_.end();
    bool fits = !is_first && within_an_hour(*utime, last->second);
    if (!channel.offset_us || survey_.stopped_us.contains(event.event_time.us)) {
      fits = fits || is_first;
    } else {
      fits = fits || within_an_hour(event.event_time.us, wrapped_sum(*utime, *channel.offset_us));
    }
    if (fits) last_stamp_us_[event.channel] = *utime;
    return fits;
  }

  static int64_t drifted_us(int64_t utime_us, const LoggedChannel& channel) {
    if (channel.drift == 0.0) return 0;
    constexpr double kMostUs = 1e9;  // of a log that lasts for days
    const double since_us = static_cast<double>(utime_us) - static_cast<double>(channel.first_us);
    return static_cast<int64_t>(std::clamp(channel.drift * since_us, -kMostUs, kMostUs));
  }

  // In the laser's clock.
  void give(const LogEvent& event, Sample sample, const LoggedChannel& channel) {
    static constexpr const char* kKinds[] = {"sensor infos", "scans",    "odometry",
                                             "imu",          "pan-tilt", "true poses"};
    ++report_.given[kKinds[sample.index()]];
    std::visit(
        [&](auto& value) {
          const int64_t shift_us = channel.shift_us + drifted_us(value.utime.us, channel);
          value.utime = survey_.stamps_are_unusable
                            ? event.event_time
                            : stamp_of(wrapped_sum(value.utime.us, shift_us));
        },
        sample);
    if (auto* truth = std::get_if<TruePose>(&sample)) {
      const bool is_shifted =
          survey_.stamps_are_unusable || channel.shift_us != 0 || channel.drift != 0.0;
      truth->is_by_arrival = truth->is_by_arrival || is_shifted;
    }
    if (const auto* scan = std::get_if<LaserScan>(&sample)) require_scan(*scan);
    queue(std::move(sample));
  }

  void finish_report() override {
    constexpr int kMostNoted = 100;
    int passed_by = 0;
    for (const auto& [name, channel] : survey_.channels) {
      if (channel.meaning != Meaning::passed_by || ++passed_by > kMostNoted) continue;
      note("%s (%s): %lld events not used for the map", name.c_str(), channel.fingerprint.c_str(),
           static_cast<long long>(channel.count));
    }
    if (passed_by > kMostNoted) note("and %d more channels", passed_by - kMostNoted);
    const files::LogDamage& damage = log_.damage();
    if (damage.places == 0) return;
    report_.dropped["damaged stretches of the log"] = damage.places;
    report_.places["damaged stretches of the log"] = "byte " + std::to_string(damage.first_offset);
    note("%lld damaged bytes skipped; `marco log repair` writes a log without them",
         static_cast<long long>(damage.bytes_skipped));
  }

  LogSurvey survey_;
  files::EventLogReader log_;
  bool announced_ = false;                        // the foreign laser
  std::map<std::string, int64_t> last_stamp_us_;  // by channel, of the samples that were used
  ForeignMessages messages_;
};

}  // namespace

std::unique_ptr<files::SampleReader> open_lcm_log(const std::filesystem::path& path,
                                                  const ForeignTable& table) {
  return std::make_unique<LcmLogReader>(path, table);
}

}  // namespace marco
