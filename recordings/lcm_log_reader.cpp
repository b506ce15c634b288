#include "recordings/lcm_log_reader.hpp"

#include <algorithm>
#include <cmath>

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

struct StampedPose {
  Utime utime;
  Pose2 pose;
};

StampedPose foreign_pose(const LogEvent& event) {
  StampedPose stamped;
  if (const auto flat = decode_message<mbot_pose2d_t>(event.bytes)) {
    stamped = {stamp_of(flat->utime),
               {static_cast<double>(flat->x), static_cast<double>(flat->y),
                normalize_angle(static_cast<double>(flat->theta))}};
  } else {
    const auto spatial = decode_message<bot_core::pose_t>(event.bytes);
    require(spatial.has_value(), kUndecodable);
    const double(&q)[4] = spatial->orientation;
    stamped = {stamp_of(spatial->utime),
               {spatial->pos[0], spatial->pos[1], yaw_of_quaternion(q[0], q[1], q[2], q[3])}};
  }
  require(is_finite(stamped.pose), "pose that is not finite");
  return stamped;
}

LaserScan foreign_scan(const LogEvent& event, bool clockwise) {
  if (const auto raw = decode_message<lidar_raw_t>(event.bytes)) {
    LaserScan scan = from_message(*raw, channels::kLidarRaw);
    for (float& bearing : scan.bearings_rad) bearing = clockwise ? -bearing : bearing;
    return scan;
  }
  const auto planar = decode_message<bot_core::planar_lidar_t>(event.bytes);
  require(planar.has_value(), kUndecodable);
  LaserScan scan = from_message(*planar, channels::kLidar);
  if (clockwise) {
    scan.first_bearing_rad = -scan.first_bearing_rad;
    scan.bearing_step_rad = -scan.bearing_step_rad;
  }
  return scan;
}

// Odometry of a base that logged only the ticks of its wheels.
class TickOdometry {
 public:
  OdometrySample add(const maebot_encoders_t& ticks, const ForeignChannel& base) {
    if (last_) {
      const double left_m = metres(last_->left_ticks_total, ticks.left_ticks_total, base);
      const double right_m = metres(last_->right_ticks_total, ticks.right_ticks_total, base);
      const Pose2 half{0.0, 0.0, 0.5 * ((right_m - left_m) / base.track_m)};
      pose_ = pose_ * half * Pose2{0.5 * (left_m + right_m), 0.0, 0.0} * half;
    }
    last_ = ticks;
    OdometrySample sample;
    sample.utime = stamp_of(ticks.utime);
    sample.odom_from_robot = pose_;
    sample.left_clicks = ticks.left_ticks_total;
    sample.right_clicks = ticks.right_ticks_total;
    return sample;
  }

 private:
  template <class Ticks>
  static double metres(Ticks from, Ticks to, const ForeignChannel& base) {
    return (static_cast<double>(to) - static_cast<double>(from)) * base.metres_per_tick;
  }

  std::optional<maebot_encoders_t> last_;
  Pose2 pose_;
};

class LcmLogReader : public files::QueuedReader {
 public:
  LcmLogReader(const std::filesystem::path& path, const ForeignTable& table)
      : survey_(survey_log(path.string(), table)), log_(path.string()) {
    report_.format = "LCM log";
    report_.paths = {path.string()};
    report_.notes = survey_.notes;
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
    require(stamp_fits(event, channel), "stamp an hour and more from its event's time");
    if (channel.meaning == Meaning::ours) {
      std::optional<Sample> sample = decode_sample(event.channel, event.bytes);
      require(sample.has_value(), kUndecodable);
      give(std::move(*sample), channel);
      return;
    }
    require(fingerprint_of(event) == channel.fingerprint, kUndecodable);
    if (channel.meaning == Meaning::lidar) {
      if (event.channel != survey_.lidar_channel) return;
      LaserScan scan = foreign_scan(event, channel.foreign.clockwise);
      if (!announced_) announce(event.channel, scan, channel.foreign);
      give(std::move(scan), channel);
    } else if (channel.meaning == Meaning::encoders) {
      const auto ticks = decode_message<maebot_encoders_t>(event.bytes);
      require(ticks.has_value(), kUndecodable);
      give(ticks_.add(*ticks, channel.foreign), channel);
    } else if (channel.meaning == Meaning::true_pose) {
      const StampedPose truth = foreign_pose(event);
      give(TruePose{truth.utime, truth.pose}, channel);
    } else {
      const StampedPose odometry = foreign_pose(event);
      OdometrySample sample;
      sample.utime = odometry.utime;
      sample.odom_from_robot = odometry.pose;
      give(sample, channel);
    }
  }

  void announce(const std::string& logged_as, const LaserScan& scan, const ForeignChannel& laser) {
    announced_ = true;
    SensorInfo info;
    info.utime = scan.utime;
    info.channel = scan.channel;
    info.range_min_m = laser.range_min_m;
    info.range_max_m = laser.range_max_m;
    queue(info);
    note("%s has no SENSOR_INFO: the laser is assumed at the turning centre, looking ahead",
         logged_as.c_str());
  }

  // Where the event's time jumps and the stamp does not, the event's time is wrong.
  bool stamp_fits(const LogEvent& event, const LoggedChannel& channel) {
    const auto utime = utime_of(event);
    if (!utime) return true;
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
  void give(Sample sample, const LoggedChannel& channel) {
    static constexpr const char* kKinds[] = {"sensor infos", "scans",    "odometry",
                                             "imu",          "pan-tilt", "true poses"};
    ++report_.given[kKinds[sample.index()]];
    std::visit(
        [&](auto& value) {
          const int64_t shift_us = channel.shift_us + drifted_us(value.utime.us, channel);
          value.utime = stamp_of(wrapped_sum(value.utime.us, shift_us));
        },
        sample);
    const auto* scan = std::get_if<LaserScan>(&sample);
    require(scan == nullptr || scan->size() >= 2, "scan of fewer than 2 beams");
    queue(std::move(sample));
  }

  void finish_report() override {
    for (const auto& [name, channel] : survey_.channels) {
      if (channel.meaning != Meaning::passed_by) continue;
      note("%s (%s): %lld events skipped", name.c_str(), channel.fingerprint.c_str(),
           static_cast<long long>(channel.count));
    }
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
  TickOdometry ticks_;
};

}  // namespace

std::unique_ptr<files::SampleReader> open_lcm_log(const std::filesystem::path& path,
                                                  const ForeignTable& table) {
  return std::make_unique<LcmLogReader>(path, table);
}

}  // namespace marco
