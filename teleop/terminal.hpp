#pragma once

#include <termios.h>

#include <optional>
#include <string>

namespace marco::teleop {

/// The keyboard of a terminal, key by key and without echo; as it was again at the end. Where
/// standard input is no terminal there are no keys.
class Keyboard {
 public:
  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// An arrow is returned as one of the letters below. @throws std::runtime_error when the terminal
  /// was closed.
  std::optional<char> key();
  bool terminal() const { return terminal_; }

  static constexpr char kUp = 'U', kDown = 'D', kLeft = 'L', kRight = 'R';

 private:
  bool terminal_ = false;
  termios before_{};
  std::string pending_;
};

}  // namespace marco::teleop
