#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/devices/kind.hpp"
#include "drivers/devices/probe.hpp"

namespace marco::drivers::devices {

/// What the kernel knows of a serial port without opening it.
struct PortIdentity {
  std::string usb_id;  ///< "10c4:ea60"; "" = not on USB
  std::string maker;
  std::string product;
  std::string serial;
};

/// @param path  of the port or of a link to it. @param classes  "/sys/class/tty"; another one in
/// tests.
PortIdentity identify_port(const std::string& path, const std::string& classes = "/sys/class/tty");

/// "USB 10c4:ea60, CP2102 USB to UART Bridge Controller"; "" without USB.
std::string describe(const PortIdentity& identity);

/// Why a stranger at this port is not asked anything unless a person names the port; "" = it may be
/// asked, since its USB identity is that of a bridge in front of a device, or of a device of ours.
std::string why_not_asked(const PortIdentity& identity);

/// A laser's scans, from Marco's own driver.
struct LaserTrial {
  double scans_per_s = 0.0;  ///< 0 = none came
  std::size_t beams = 0;
  std::string state;  ///< what the driver says
};

/// Whether a trial leaves the laser's settings alone. A SICK LMS writes what the driver asks for
/// into its memory, so it is only asked.
bool may_be_tried(Kind laser);

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
