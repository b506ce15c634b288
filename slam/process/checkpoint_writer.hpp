#pragma once

#include <functional>
#include <optional>
#include <string>

#include "lcm_tools/base/utime.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "slam/process/background_job.hpp"

namespace marco::slam {

/// When a checkpoint is due, and who writes it. Not thread-safe.
class CheckpointWriter {
 public:
  /// @param every_s  of message time. @param drops  counts those that could not be written
  CheckpointWriter(double every_s, process::DropCounter& drops)
      : every_s_(every_s), drops_(drops) {}

  /// From here on no scan waits for the disk.
  void write_in_background() { in_background_ = true; }
  /// Whether one is due; a clock that steps back far makes it due, too. One that is still being
  /// written is waited for by not being due.
  bool is_due(Utime utime);
  /// Waits for the disk; what follows does, too.
  void write_in_foreground();
  /// @param job  writes; throws std::runtime_error when it cannot, on a full disk
  void write(std::function<void()> job);

 private:
  double every_s_;
  process::DropCounter& drops_;
  std::optional<Utime> saved_;
  BackgroundJob job_;
  bool in_background_ = false;
};

}  // namespace marco::slam
