#pragma once

#include <string>
#include <vector>

namespace marco::drivers {

enum class DeviceKind { serial, gamepad, camera };

/// A device that stands ready: "/dev/ttyUSB0", and its lasting name or "".
struct DeviceSeen {
  std::string path;
  std::string by_id;  ///< "/dev/serial/by-id/usb-Silicon_Labs_CP2102_0001-if00-port0"
};

/// Of serial ports those that were plugged in: a PC's ttyS are there with nothing on them.
/// @param folder  "/dev"; another one in tests.
std::vector<DeviceSeen> devices_seen(DeviceKind kind, const std::string& folder = "/dev");

/// What is known of a device that could not be opened.
struct OpenFailure {
  std::string path;
  int error = 0;  ///< errno
  DeviceKind kind = DeviceKind::serial;
  std::vector<DeviceSeen> seen;
  std::string group;   ///< that the device belongs to; "" = not known
  std::string holder;  ///< "minicom (4711)"; "" = not known
};

/// What happened and what to do, in one line that begins with the path.
std::string open_failure_text(const OpenFailure& failure);

/// As above, with what this host's /dev and /proc tell of `path`.
std::string why_not_open(const std::string& path, int error, DeviceKind kind);

/// Who has the device open: "minicom (4711)", "" when nobody that we may see. Not this process.
std::string holder_of(const std::string& path);

}  // namespace marco::drivers
