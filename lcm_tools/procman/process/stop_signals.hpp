#pragma once

#include "lcm_tools/procman/process/descriptor.hpp"

namespace marco::procman {

/// SIGINT, SIGTERM, SIGHUP and SIGQUIT as input. They are blocked in this thread and those it
/// starts: make it first. Also ignores SIGPIPE.
class StopSignals {
 public:
  StopSignals();

  /// Readable when a signal has come.
  int fd() const { return signals_.get(); }
  /// Reads a signal. @returns whether one had come.
  bool take();
  /// A terminal is gone, of which no SIGHUP came.
  void on_hang_up() { ++count_; }
  /// Signals so far.
  int count() const { return count_; }

 private:
  Descriptor signals_;
  int count_ = 0;
};

}  // namespace marco::procman
