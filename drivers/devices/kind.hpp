#pragma once

#include <string>

namespace marco::drivers::devices {

/// Who speaks on a serial line.
enum class Kind {
  silence,
  bytes,  ///< of nobody known
  text,
  login,  ///< a terminal that waits for a person
  nmea,   ///< a satellite receiver
  ldlidar,
  ydlidar,
  rplidar,
  sick,
  hokuyo,
  cola,
  leuze,
  imu,
  bno055,
  p2os,
  textbase,
  create,
  kobuki,
  hcs12_base,
  hcs12_pantilt,
};

/// Whether Marco has a driver for it.
inline bool is_device(Kind kind) { return kind >= Kind::ldlidar; }
inline bool is_laser(Kind kind) { return kind >= Kind::ldlidar && kind <= Kind::leuze; }

/// Who it is, as far as its bytes tell.
struct Claim {
  Kind kind = Kind::silence;
  std::string name;  ///< for a person: "RPLIDAR A2"; of text the newest line
};

}  // namespace marco::drivers::devices
