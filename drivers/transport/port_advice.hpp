#pragma once

#include <string>
#include <vector>

namespace marco::drivers {

enum class DeviceKind { serial, gamepad, camera };

/// A device that is present: "/dev/ttyUSB0", and its persistent name or "".
struct DeviceSeen {
  std::string path;
  std::string by_id;  ///< "/dev/serial/by-id/usb-Silicon_Labs_CP2102_0001-if00-port0"
};

/// The devices of a kind. Of serial ports those that can be plugged in: a PC's ttyS always exist.
/// @param folder  "/dev"; another one in tests.
std::vector<DeviceSeen> devices_seen(DeviceKind kind, const std::string& folder = "/dev");

/// A device that could not be opened, and what is known about it.
struct OpenFailure {
  std::string path;
  int error = 0;  ///< errno
  DeviceKind kind = DeviceKind::serial;
  std::vector<DeviceSeen> seen;
  std::string group;   ///< owning the device; "" = not known
  std::string holder;  ///< "minicom (4711)"; "" = not known
};

/// What happened and what to do, in one line that begins with the path.
std::string open_failure_text(const OpenFailure& failure);

/// As above, filled in from this host's /dev and /proc.
std::string why_not_open(const std::string& path, int error, DeviceKind kind);

/// The other process that has the device open: "minicom (4711)"; "" when none is visible to us.
std::string holder_of(const std::string& path);

}  // namespace marco::drivers
