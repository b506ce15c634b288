#pragma once

#include <map>
#include <optional>
#include <string>

#include "common/samples.hpp"
#include "drivers/base/local_map.hpp"

namespace marco::drivers {

/// Adds to a list in words; nothing to add: nothing.
inline void add_words(std::string& list, const std::string& words, const char* separator = "; ") {
  if (!words.empty()) list += (list.empty() ? "" : separator) + words;
}

/// What the guard may believe of its sensors: where each is mounted, whether its readings come, and
/// whether they show what is in the body's way. Keeps 16 channels at most.
class SensorWatch {
 public:
  static constexpr const char* kSonars = "SONAR";

  /// @param body  the heights that are in the body's way.
  explicit SensorWatch(const Heights& body) : body_(body) {}

  /// The first SensorInfo of a laser or of the pan-tilt holds. Another one is refused, and while
  /// such come the sensor is in dispute.
  void on_info(const SensorInfo& info, Utime now);
  void on_pantilt(const PanTiltState& state, Utime now);
  /// A reading came. @param sensor  a laser's planar channel, or kSonars. @param stamp  its own.
  /// @returns false for a reading that came before, as on LIDAR_RAW, or of a seventeenth sensor.
  bool on_reading(const std::string& sensor, Utime stamp, Utime now);
  /// The reading showed something at a height that is in the way.
  void on_useful(const std::string& sensor, Utime now) { sensors_[sensor].useful = now; }
  /// @returns the names of those that were known, with commas.
  std::string forget();

  /// nullptr: not known yet.
  const SensorInfo* info_of(const std::string& sensor) const;
  /// Nothing: it is on a pan-tilt that sends no angles.
  std::optional<Pose3> robot_from(const SensorInfo& laser, Utime now) const;
  /// The heights at which a laser's returns count: all of a level laser, since what it sees is as
  /// high as the robot.
  Heights counted(const Pose3& robot_from_laser) const;

  /// "LIDAR is silent for 0.7 s": its readings came, and come no more. "" = none.
  std::string silent(Utime now) const;
  /// Why no sensor shows what is in the way; "" = one does.
  std::string why_blind(Utime now) const;
  /// "another mount for LIDAR is refused", for ten seconds; "" = none is.
  std::string dispute(Utime now) const;

 private:
  struct Sensor {
    std::optional<SensorInfo> info;
    Utime stamp, read, useful, refused;  ///< of the last reading, and when these came
    double interval_s = 0.0;             ///< between its readings; 0 = not known
  };
  Sensor* known_or_new(const std::string& name);
  std::string why_useless(const std::string& name, const Sensor& sensor, Utime now) const;

  Heights body_;
  std::map<std::string, Sensor> sensors_;
  PanTiltState pantilt_;
  Utime pantilt_came_;
};

}  // namespace marco::drivers
