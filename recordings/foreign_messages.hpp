#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/samples.hpp"
#include "marco/maebot_encoders_t.hpp"
#include "recordings/foreign.hpp"
#include "recordings/rolled_wheels.hpp"

namespace marco {

/// Odometry of a base that reports only the ticks of its wheels.
class TickOdometry {
 public:
  OdometrySample add(const maebot_encoders_t& ticks, const ForeignChannel& base);

 private:
  std::optional<maebot_encoders_t> last_;
  Pose2 pose_;
};

/// Turns another system's LCM messages into samples, in the order of their channel: of a log, or
/// live. Not thread-safe.
class ForeignMessages {
 public:
  /// A scan goes to LIDAR, or to LIDAR_RAW if it has the times of its beams.
  /// @param entry  of the message's channel; its meaning is lidar, odometry, encoders or true_pose
  /// @throws std::invalid_argument saying what is wrong with the message.
  Sample decode(std::span<const uint8_t> bytes, const ForeignChannel& entry);

  /// What a laser that has no SENSOR_INFO is taken to be: at the turning centre, looking ahead.
  /// @param scan  from the last decode()
  SensorInfo info_of(const LaserScan& scan, const ForeignChannel& entry) const;

 private:
  LaserScan decode_scan(std::span<const uint8_t> bytes, const ForeignChannel& entry);

  TickOdometry ticks_;
  std::optional<double> told_min_m_, told_max_m_;  // by the last scan itself
};

/// Bearings counter-clockwise, as everywhere else, of a scan as its message told it.
///
/// By `entry.clockwise`, and for `entry.direction_by_stamp` by what MBot's drivers of RPLidars do.
/// The laser turns clockwise. Where bearings rise with time nonetheless, the place of the stamp
/// tells which driver it is: the first beam's (until 2022), then the angles are the device's own,
/// clockwise; or the end of the turn (since 2023), then the angles are counter-clockwise and the
/// beams' times run against the order of measurement: they are put in order by the angle turned.
/// Its stamp is afterwards the earliest beam's.
void settle_direction(LaserScan& scan, const ForeignChannel& entry);

/// The first entry that fits a channel and the type of its message; nullptr: none.
const ForeignChannel* entry_of(const ForeignTable& table,
                               const std::string& channel,
                               const std::string& fingerprint);

/// The stamp of a message [us]: the first field of most types; ROS' types begin otherwise. Nothing
/// of a message that is too short.
std::optional<int64_t> utime_in(std::span<const uint8_t> message);

/// Of a message's type: 16 hexadecimal digits; "" where it is too short to have one.
std::string fingerprint_in(std::span<const uint8_t> message);
std::string fingerprint_text(int64_t hash);
template <class Message>
std::string fingerprint_of() {
  return fingerprint_text(Message::getHash());
}

}  // namespace marco
