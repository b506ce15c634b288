#include "lcm_tools/process/progress.hpp"

#include <unistd.h>

#include <cstdio>

#include "lcm_tools/base/printable.hpp"

namespace marco::process {

Progress::Progress(const std::string& what)
    : what_(printable(what)), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double part) {
  if (!terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(part * kWidth);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(kWidth - filled), '.');
  std::fprintf(stderr, "\r%s [%s] %3.0f %%\033[K", what_.c_str(), bar.c_str(), part * 100.0);
}

}  // namespace marco::process
