#pragma once

#include <string>

#include "drivers/devices/kind.hpp"
#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers::devices {

/// A laser's scans, from Marco's own driver.
struct LaserTrial {
  double scans_per_s = 0.0;  ///< 0 = none came
  std::size_t beams = 0;
  std::string state;  ///< what the driver says
};

/// Whether a trial leaves the laser's settings alone. A SICK LMS writes what the driver asks for
/// into its memory, so it is only asked.
bool may_be_tried(Kind laser);

/// Lets the driver run until some scans came, ten seconds at most, then stops the laser. @throws
/// StreamLost.
LaserTrial try_laser(ByteStream& stream, const Clock& clock, Kind laser, int baud);

}  // namespace marco::drivers::devices
