#pragma once

// ncurses without its macros, which would rename our members.
#define NCURSES_NOMACROS
#include <curses.h>

namespace marco::procman {

/// The key code of Ctrl and a letter.
constexpr int control(char letter) { return letter & 0x1f; }
constexpr int kEscape = 27;

constexpr bool is_enter(int key) { return key == '\n' || key == '\r' || key == KEY_ENTER; }
constexpr bool is_backspace(int key) {
  return key == KEY_BACKSPACE || key == 127 || key == control('h');
}
constexpr bool is_text(int key) { return key >= ' ' && key < 256 && key != 127; }

}  // namespace marco::procman
