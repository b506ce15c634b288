#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "lcm_tools/log/select.hpp"
#include "lcm_tools/process/progress.hpp"
#include "lcm_tools/process/stop_signal.hpp"

namespace marco::logs {

/// A progress line that shows itself only when the work takes longer than a second. Ctrl-C ends
/// the work: its callback throws process::Interrupted.
class LateProgress {
 public:
  explicit LateProgress(std::string what) : what_(std::move(what)) {}

  /// Holds as long as this object.
  OnProgress callback() {
    return [this](double part) {
      process::end_if_interrupted();
      if (!shown_ && std::chrono::steady_clock::now() - start_ < std::chrono::seconds(1)) return;
      if (!shown_) shown_.emplace(what_);
      shown_->update(std::clamp(part, 0.0, 1.0));
    };
  }

 private:
  std::string what_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::optional<process::Progress> shown_;
};

}  // namespace marco::logs
