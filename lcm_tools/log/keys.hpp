#pragma once

#include <termios.h>

#include <cstdint>
#include <string>

namespace marco::logs {

enum class Key {
  none,
  pause,
  step,
  back,
  forward,
  far_back,
  far_forward,
  start,
  faster,
  slower,
  normal_speed,
  loop,
  loop_start,
  loop_end,
  loop_clear,
  help,
  quit
};

/// Takes the first key off `typed`, arrow keys and the like included; what means nothing is taken
/// off, too. Nothing is taken of an escape sequence that has not arrived whole.
Key take_key(std::string& typed);

/// What the keys do, for a person.
extern const char* const kKeysHelp;

/// The keyboard without waiting for Enter, while it exists; nothing where stdin is no terminal.
class Keyboard {
 public:
  enum class Use { keys, only_wait };
  explicit Keyboard(Use use);
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  bool is_there() const { return there_; }

  /// Waits until a key was pressed, a signal came or `timeout_us` have passed.
  /// @returns what was typed.
  std::string wait(int64_t timeout_us);

 private:
  bool there_ = false;
  termios before_ = {};
};

}  // namespace marco::logs
