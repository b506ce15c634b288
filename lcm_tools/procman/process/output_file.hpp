#pragma once

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/keeper_message.hpp"

namespace marco::procman {

/// The file that a keeper writes a command's output to. Beyond output_limit it becomes FILE.1,
/// replacing the one before, and a new one begins: a command that writes without end must not fill
/// the disk.
class OutputFile {
 public:
  /// @param state outlives it; its output_* fields say which file, and are kept up to date.
  explicit OutputFile(KeeperMessage& state) : state_(state) {}

  /// Opens state.output_file for appending. @throws std::runtime_error.
  void open();
  /// Bytes that cannot be written are counted in state.output_lost.
  void write(const char* bytes, std::size_t size);

 private:
  void begin_new_file();

  KeeperMessage& state_;
  Descriptor file_;
};

}  // namespace marco::procman
