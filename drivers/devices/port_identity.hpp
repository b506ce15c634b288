#pragma once

#include <string>

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

}  // namespace marco::drivers::devices
