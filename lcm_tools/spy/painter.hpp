#pragma once

#include <optional>

#include "lcm_tools/spy/canvas.hpp"
#include "lcm_tools/spy/view.hpp"

namespace marco::spy {

/// The terminal, by ncurses. One at a time; gives the terminal back when destroyed.
class Painter {
 public:
  /// @throws std::runtime_error when stdin or stdout is no terminal, or TERM names an unknown one.
  Painter();
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  int width() const;
  int height() const;
  void paint(const Canvas& canvas);
  /// Waits up to `timeout_ms` for a key; nothing when none came (or the window changed its size).
  std::optional<KeyPress> key(int timeout_ms);

 private:
  bool unicode_ = false;
};

}  // namespace marco::spy
