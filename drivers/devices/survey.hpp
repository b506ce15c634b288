#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/devices/laser_trial.hpp"
#include "drivers/devices/port_identity.hpp"
#include "drivers/devices/probe.hpp"

namespace marco::drivers::devices {

struct Port {
  std::string path;  ///< as drivers should be given it: by its persistent name where it has one
  PortIdentity identity;
  bool named = false;  ///< by a person: it may be asked whatever it is
};

/// The serial ports that can be plugged in. @param folder "/dev"; another one in tests.
std::vector<Port> ports_here(const std::string& folder = "/dev",
                             const std::string& classes = "/sys/class/tty");

/// What was found at a port.
struct PortReport {
  Port port;
  std::string trouble;  ///< why it was not opened, or how it was lost; "" = none
  std::string unasked;  ///< why it was only listened to; "" = it was asked
  Finding finding;
  std::optional<LaserTrial> trial;
};

/// Probes one port. A port that another process holds is not opened: opening alone moves its lines,
/// which stops motors and resets boards. @param listen_only  not a byte is sent, no laser started.
PortReport survey(const Port& port, bool listen_only);
/// As above on a line that is open. @throws StreamLost.
void survey_line(ByteStream& stream, const Clock& clock, PortReport& report, bool listen_only);

/// For a person, one line.
std::string describe(const PortReport& report);
/// "marco-rplidar"; "" for what Marco has no driver for.
std::string program_of(Kind kind);

}  // namespace marco::drivers::devices
