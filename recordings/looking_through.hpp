#pragma once

#include <filesystem>

#include "lcm_tools/process/progress.hpp"
#include "lcm_tools/process/stop_signal.hpp"

namespace marco {

/// Of a first look at a recording, which may take minutes: shows how far it is, and ends when the
/// user interrupts.
class LookingThrough {
 public:
  explicit LookingThrough(const std::filesystem::path& path)
      : progress_("looking through " + path.filename().string()) {}

  /// To be called often. @param part  done, 0..1. @throws process::Interrupted
  void update(double part) {
    process::end_if_interrupted();
    progress_.update(part);
  }

 private:
  process::Progress progress_;
};

}  // namespace marco
