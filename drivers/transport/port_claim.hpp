#pragma once

#include <string>

#include "drivers/transport/serial_stream.hpp"

/// A simulator's link `ports/base` leads to a pseudo-terminal. When the simulator is killed the
/// link stays, and the system gives the terminal's number to whoever opens one next: a person's
/// shell. So a simulator holds a lock beside each link, `ports/.base.lock`, which ends with its
/// process and names the terminal, and a driver opens no pseudo-terminal before it has looked.
namespace marco::drivers {

/// Holds the claim as long as it stays open. @throws std::runtime_error when a simulator that runs
/// holds the link.
FileHandle claim_port(const std::string& link, const std::string& terminal);
void give_up_port(const std::string& link, FileHandle& claim);

/// @param fd  open at `path`, any terminal.
/// @returns why a driver must keep its hands off, one line for a person; "" = it is a device.
std::string why_no_device(const std::string& path, int fd);

}  // namespace marco::drivers
