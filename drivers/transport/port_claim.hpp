#pragma once

#include <string>

#include "drivers/transport/serial_stream.hpp"

/// A simulator's link `ports/base` leads to a pseudo-terminal. When the simulator is killed, the
/// link remains and the system reuses the terminal's number, for instance for a person's shell. So
/// a simulator holds a lock next to each link, `ports/.base.lock`. The lock names the terminal and
/// ends with the process. A driver checks it before it opens a pseudo-terminal.
namespace marco::drivers {

/// @returns the claim, held while open. @throws std::runtime_error when another running simulator
/// holds the link.
FileHandle claim_port(const std::string& link, const std::string& terminal);
void give_up_port(const std::string& link, FileHandle& claim);

/// @param fd  open at `path`, any terminal.
/// @returns why a driver must not use it, one line for a person; "" = it is a device.
std::string why_no_device(const std::string& path, int fd);

}  // namespace marco::drivers
