#include "recordings/lcm_log_reader.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "bot_core/pose_t.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/stamp.hpp"
#include "marco/maebot_encoders_t.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "recordings/log_survey.hpp"

namespace marco {
namespace {

using files::LogEvent;

template <class Message>
std::optional<Message> decode_whole(const LogEvent& event) {
  Message message;
  const int size = static_cast<int>(event.bytes.size());
  if (message.decode(event.bytes.data(), 0, size) != size) return std::nullopt;
  return message;
}

double yaw_of(const double (&q)[4]) {
  return std::atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3]));
}

class LcmLogReader : public files::SampleReader {
 public:
  LcmLogReader(const std::filesystem::path& path, const ForeignTable& table)
      : survey_(survey_log(path.string(), table)), log_(path.string()) {
    report_.format = "LCM log";
    report_.paths = {path.string()};
    report_.notes = survey_.notes;
  }

  std::optional<Sample> next() override {
    while (pending_.empty()) {
      const std::optional<LogEvent> event = log_.next();
      if (!event) {
        finish_report();
        return std::nullopt;
      }
      read(*event);
    }
    Sample sample = std::move(pending_.front());
    pending_.pop_front();
    return sample;
  }
  const files::InputReport& report() const override { return report_; }
  double progress() const override {
    return static_cast<double>(log_.position_bytes()) /
           static_cast<double>(std::max<int64_t>(1, log_.size_bytes()));
  }

 private:
  void read(const LogEvent& event);
  void read_foreign(const LogEvent& event, const LoggedChannel& channel);
  void read_foreign_lidar(const LogEvent& event, const LoggedChannel& channel);
  void read_encoders(const maebot_encoders_t& ticks, const LoggedChannel& channel);
  void emit(Sample sample, const LoggedChannel& channel);
  bool stamp_fits(const LogEvent& event, const LoggedChannel& channel);
  void finish_report();

  LogSurvey survey_;
  files::EventLogReader log_;
  bool announced_ = false;
  std::map<std::string, int64_t> last_stamp_us_;  ///< by channel, of those that were used
  std::optional<maebot_encoders_t> last_ticks_;
  Pose2 encoder_pose_;
  std::deque<Sample> pending_;
  bool finished_ = false;
  files::InputReport report_;
};

void LcmLogReader::read(const LogEvent& event) {
  const auto entry = survey_.channels.find(event.channel);
  if (entry == survey_.channels.end()) return;
  const LoggedChannel& channel = entry->second;
  const std::string place = "event " + std::to_string(event.number) + " (" + event.channel + ")";
  if (channel.meaning != LoggedChannel::Meaning::passed_by && !stamp_fits(event, channel)) {
    report_.drop("stamp an hour and more from its event's time", place);
    return;
  }
  try {
    if (channel.meaning == LoggedChannel::Meaning::ours) {
      std::optional<Sample> sample = decode_sample(event.channel, event.bytes);
      if (sample) {
        emit(std::move(*sample), channel);
      } else {
        report_.drop("undecodable", place);
      }
    } else if (channel.meaning != LoggedChannel::Meaning::passed_by) {
      if (fingerprint_of(event) == channel.fingerprint) {
        read_foreign(event, channel);
      } else {
        report_.drop("undecodable", place);
      }
    }
  } catch (const std::invalid_argument& bad) {
    report_.drop(bad.what(), place);
  }
}

bool LcmLogReader::stamp_fits(const LogEvent& event, const LoggedChannel& channel) {
  const auto utime = utime_of(event);
  if (!utime) return true;
  const auto is_near = [](int64_t a, int64_t b) {
    constexpr int64_t kFarthestUs = 3'600'000'000;
    // Unsigned: a flipped bit may make either as large as can be.
    const auto off = static_cast<int64_t>(static_cast<uint64_t>(a) - static_cast<uint64_t>(b));
    return off > -kFarthestUs && off < kFarthestUs;
  };
  const auto last = last_stamp_us_.find(event.channel);
  // Where the event's time jumps and the stamp does not, it is the event's time that is wrong.
  bool fits = last != last_stamp_us_.end() && is_near(*utime, last->second);
  if (!channel.offset_us || survey_.stopped_us.contains(event.event_time.us)) {
    fits = fits || last == last_stamp_us_.end();
  } else {
    const auto expected_us = static_cast<int64_t>(static_cast<uint64_t>(*utime) +
                                                  static_cast<uint64_t>(*channel.offset_us));
    fits = fits || is_near(event.event_time.us, expected_us);
  }
  if (fits) last_stamp_us_[event.channel] = *utime;
  return fits;
}

void LcmLogReader::read_foreign(const LogEvent& event, const LoggedChannel& channel) {
  const std::string& fingerprint = channel.fingerprint;
  const std::string place = "event " + std::to_string(event.number) + " (" + event.channel + ")";
  if (channel.meaning == LoggedChannel::Meaning::lidar) {
    if (event.channel == survey_.lidar_channel) read_foreign_lidar(event, channel);
    return;
  }
  if (channel.meaning == LoggedChannel::Meaning::encoders) {
    const auto ticks = decode_whole<maebot_encoders_t>(event);
    if (ticks) {
      read_encoders(*ticks, channel);
    } else {
      report_.drop("undecodable", place);
    }
    return;
  }
  Utime utime;
  Pose2 pose;
  if (const auto pose2 = decode_whole<mbot_pose2d_t>(event)) {
    utime = stamp_of(pose2->utime);
    pose = {static_cast<double>(pose2->x), static_cast<double>(pose2->y),
            normalize_angle(static_cast<double>(pose2->theta))};
  } else if (const auto pose3 = decode_whole<bot_core::pose_t>(event)) {
    utime = stamp_of(pose3->utime);
    pose = {pose3->pos[0], pose3->pos[1], yaw_of(pose3->orientation)};
  } else {
    report_.drop("undecodable (" + fingerprint + ")", place);
    return;
  }
  require(is_finite(pose), "pose that is not finite");
  if (channel.meaning == LoggedChannel::Meaning::true_pose) {
    emit(TruePose{utime, pose}, channel);
  } else {
    OdometrySample sample;
    sample.utime = utime;
    sample.odom_from_robot = pose;
    emit(sample, channel);
  }
}

void LcmLogReader::read_foreign_lidar(const LogEvent& event, const LoggedChannel& channel) {
  LaserScan scan;
  if (const auto raw = decode_whole<lidar_raw_t>(event)) {
    scan = from_message(*raw, channels::kLidarRaw);
    if (channel.foreign.clockwise) {
      for (float& bearing : scan.bearings_rad) bearing = -bearing;
    }
  } else if (const auto planar = decode_whole<bot_core::planar_lidar_t>(event)) {
    scan = from_message(*planar, channels::kLidar);
    if (channel.foreign.clockwise) {
      scan.first_bearing_rad = -scan.first_bearing_rad;
      scan.bearing_step_rad = -scan.bearing_step_rad;
    }
  } else {
    report_.drop("undecodable", "event " + std::to_string(event.number));
    return;
  }
  if (!announced_) {
    announced_ = true;
    SensorInfo info;
    info.utime = scan.utime;
    info.channel = scan.channel;
    info.range_min_m = channel.foreign.range_min_m;
    info.range_max_m = channel.foreign.range_max_m;
    pending_.emplace_back(info);
    report_.notes.push_back(event.channel +
                            " says nothing of its place: taken to be at the turning centre, ahead");
  }
  emit(std::move(scan), channel);
}

void LcmLogReader::read_encoders(const maebot_encoders_t& ticks, const LoggedChannel& channel) {
  if (last_ticks_) {
    const double left_m = (static_cast<double>(ticks.left_ticks_total) -
                           static_cast<double>(last_ticks_->left_ticks_total)) *
                          channel.foreign.metres_per_tick;
    const double right_m = (static_cast<double>(ticks.right_ticks_total) -
                            static_cast<double>(last_ticks_->right_ticks_total)) *
                           channel.foreign.metres_per_tick;
    const double turn_rad = (right_m - left_m) / channel.foreign.track_m;
    const Pose2 half{0.0, 0.0, 0.5 * turn_rad};
    encoder_pose_ = encoder_pose_ * half * Pose2{0.5 * (left_m + right_m), 0.0, 0.0} * half;
  }
  last_ticks_ = ticks;
  OdometrySample sample;
  sample.utime = stamp_of(ticks.utime);
  sample.odom_from_robot = encoder_pose_;
  sample.left_clicks = ticks.left_ticks_total;
  sample.right_clicks = ticks.right_ticks_total;
  emit(sample, channel);
}

void LcmLogReader::emit(Sample sample, const LoggedChannel& channel) {
  static constexpr const char* kNames[] = {"sensor infos", "scans",    "odometry",
                                           "imu",          "pan-tilt", "true poses"};
  ++report_.given[kNames[sample.index()]];
  // Unsigned: a shift learnt from hostile stamps may be as large as can be.
  const auto shifted = [&channel](Utime utime) {
    return stamp_of(static_cast<int64_t>(static_cast<uint64_t>(utime.us) +
                                         static_cast<uint64_t>(channel.shift_us)));
  };
  std::visit([&](auto& value) { value.utime = shifted(value.utime); }, sample);
  if (const auto* scan = std::get_if<LaserScan>(&sample); scan != nullptr && scan->size() < 2) {
    report_.drop("scan of fewer than 2 beams", "scan " + std::to_string(report_.given.at("scans")));
    return;
  }
  pending_.push_back(std::move(sample));
}

void LcmLogReader::finish_report() {
  if (finished_) return;
  finished_ = true;
  for (const auto& [name, channel] : survey_.channels) {
    if (channel.meaning != LoggedChannel::Meaning::passed_by) continue;
    report_.notes.push_back(name + " (" + channel.fingerprint +
                            "): " + std::to_string(channel.count) + " events passed by");
  }
  const files::LogDamage& damage = log_.damage();
  if (damage.places == 0) return;
  report_.dropped["damaged stretches of the log"] = damage.places;
  report_.places["damaged stretches of the log"] = "byte " + std::to_string(damage.first_offset);
  report_.notes.push_back(std::to_string(damage.bytes_skipped) +
                          " damaged bytes skipped; `marco log repair` writes a log without them");
}

}  // namespace

std::unique_ptr<files::SampleReader> open_lcm_log(const std::filesystem::path& path,
                                                  const ForeignTable& table) {
  return std::make_unique<LcmLogReader>(path, table);
}

}  // namespace marco
