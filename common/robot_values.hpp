#pragma once

#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

/// How long an order to move is valid: a velocity is driven for this long unless a newer one
/// arrives, an older order is refused, and a gamepad or keyboard repeats its order within it.
inline constexpr double kOrderHoldsS = 0.5;

/// An order to a base (lcmtypes/marco/base_command_t.lcm); only the fields of its kind count.
struct BaseCommand {
  enum class Kind { stop, move, turn, velocity, go_to, set_speed, forget_sensors };

  Utime utime;
  int64_t id = 0;
  Kind kind = Kind::stop;
  double distance_m = 0.0;  ///< < 0 = backwards
  double angle_rad = 0.0;
  double velocity_m_per_s = 0.0;
  double yaw_rate_rad_per_s = 0.0;
  Eigen::Vector2d point_m = Eigen::Vector2d::Zero();  ///< odom frame
  double max_velocity_m_per_s = 0.0;                  ///< 0 = unchanged
  double max_yaw_rate_rad_per_s = 0.0;
  double acceleration_m_per_s2 = 0.0;
};

/// What a base is doing.
struct BaseStatus {
  enum class Link { down, starting, up };
  enum class Command { none, running, done, shortened, refused, aborted };

  Utime utime;
  std::string base;
  Link link = Link::down;
  int64_t command_id = 0;
  Command command = Command::none;
  bool motors_on = false;
  std::vector<double> battery_v;
  std::vector<bool> bumpers;
  std::string note;  ///< one line of text
};

/// Stops every base until it is released (lcm_tools/lcmtypes/marco/emergency_stop_t.lcm).
struct EmergencyStop {
  Utime utime;
  bool engaged = true;
  std::string sender;
  std::string reason;
};

/// The note of a base that is under an emergency stop begins with this.
inline constexpr const char* kEmergencyStopNote = "emergency stop";
/// What a base's obstacle guard has to say stands at the end of the note, behind this.
inline constexpr const char* kGuardNote = "guard: ";

/// A note in two parts: its own text, and the guard's ("at most 0.2 m/s: no laser or sonar
/// data"; "" = it sees).
struct BaseNote {
  std::string text, guard;
  explicit BaseNote(const std::string& note) : text(note) {
    const std::size_t at = note.rfind(kGuardNote);
    if (at == std::string::npos) return;
    guard = note.substr(at + std::string(kGuardNote).size());
    text.resize(at < 2 ? 0 : at - 2);  // "; " lies between
  }
};

/// One transducer of a ring.
struct SonarReading {
  double range_m = 0.0;    ///< 0 = no echo
  Pose2 robot_from_sonar;  ///< looks along its x axis
};

struct SonarRing {
  Utime utime;  ///< the newest reading
  std::vector<SonarReading> readings;
  double cone_rad = 0.0;  ///< full opening angle
};

struct PanTiltCommand {
  enum class Kind { stop, go_to };

  Utime utime;
  Kind kind = Kind::stop;
  double pan_rad = 0.0;
  double tilt_rad = 0.0;
  double pan_rate_rad_per_s = 0.0;  ///< 0 = the driver's own
  double tilt_rate_rad_per_s = 0.0;
};

struct GamepadState {
  Utime utime;
  bool connected = true;
  std::vector<float> axes;  ///< -1 (left, up) .. 1
  std::vector<bool> buttons;
};

}  // namespace marco
