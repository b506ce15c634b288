#pragma once

#include <chrono>
#include <string>

namespace marco::process {

/// One line on stderr, rewritten at most ten times a second. Silent when stderr is not a terminal.
class Progress {
 public:
  /// @param what "reading intel.log"
  explicit Progress(const std::string& what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param part done, 0..1
  void update(double part);

 private:
  std::string what_;
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace marco::process
