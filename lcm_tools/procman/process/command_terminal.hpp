#pragma once

#include <sys/types.h>

#include <string>

#include "lcm_tools/procman/process/descriptor.hpp"

namespace marco::procman {

/// The terminal that a command runs in. Its opener is the session leader, so the command's death
/// does not hang it up: output that was written but not read yet stays readable.
class CommandTerminal {
 public:
  /// @throws std::runtime_error, as start().
  void open();

  /// Starts the command in it, in a process group of its own. @returns its pid.
  pid_t start(const std::string& exec);

  /// Readable when the command has written.
  int fd() const { return master_.get(); }
  /// @returns how many bytes were read; <= 0 when there are none.
  ssize_t read(char* bytes, std::size_t room) { return ::read(master_.get(), bytes, room); }

 private:
  Descriptor master_;
  Descriptor slave_;
};

}  // namespace marco::procman
