#include "lcm_tools/spy/painter.hpp"

#include <langinfo.h>
#include <ncursesw/ncurses.h>
#include <unistd.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

namespace marco::spy {
namespace {

enum Pair : short { pair_green = 1, pair_yellow, pair_red, pair_title };

attr_t attributes(Style style) {
  switch (style) {
    case Style::normal:
      return A_NORMAL;
    case Style::dim:
      return A_DIM;
    case Style::bold:
      return A_BOLD;
    case Style::title:
      return A_BOLD | static_cast<attr_t>(COLOR_PAIR(pair_title));
    case Style::good:
      return static_cast<attr_t>(COLOR_PAIR(pair_green));
    case Style::warn:
      return static_cast<attr_t>(COLOR_PAIR(pair_yellow));
    case Style::bad:
      return A_BOLD | static_cast<attr_t>(COLOR_PAIR(pair_red));
    case Style::selected:
      return A_REVERSE;
  }
  return A_NORMAL;
}

// For terminals without UTF-8.
char ascii(char32_t glyph) {
  if (glyph < 0x80) return static_cast<char>(glyph);
  if (glyph >= 0x2800 && glyph < 0x2900) return '*';
  if (glyph >= 0x2581 && glyph <= 0x2588) return "_.,-=+*#"[glyph - 0x2581];
  switch (glyph) {
    case U'▸':
    case U'▶':
      return '>';
    case U'▾':
      return 'v';
    case U'▴':
    case U'▲':
      return '^';
    case U'·':
      return '.';
    case U'│':
      return '|';
    default:
      return glyph >= 0x2500 && glyph < 0x2580 ? '-' : '?';
  }
}

}  // namespace

Painter::Painter() {
  if (isatty(STDIN_FILENO) == 0 || isatty(STDOUT_FILENO) == 0) {
    throw std::runtime_error("the screen needs a terminal; without one use --once or --json");
  }
  std::setlocale(LC_ALL, "");
  // No locale set, as over a bare ssh: the terminal can do UTF-8 all the same nearly always.
  if (std::strcmp(nl_langinfo(CODESET), "UTF-8") != 0 && std::getenv("LC_ALL") == nullptr) {
    std::setlocale(LC_CTYPE, "C.UTF-8");
  }
  unicode_ = std::strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
  if (newterm(nullptr, stdout, stdin) == nullptr) {
    const char* term = std::getenv("TERM");
    throw std::runtime_error(std::string("TERM=") + (term == nullptr ? "" : term) +
                             " is not a known terminal; try TERM=xterm");
  }
  noecho();
  cbreak();
  curs_set(0);
  keypad(stdscr, TRUE);
  set_escdelay(25);
  if (has_colors()) {
    start_color();
    use_default_colors();
    init_pair(pair_green, COLOR_GREEN, -1);
    init_pair(pair_yellow, COLOR_YELLOW, -1);
    init_pair(pair_red, COLOR_RED, -1);
    init_pair(pair_title, COLOR_WHITE, COLOR_BLUE);
  }
}

Painter::~Painter() { endwin(); }

int Painter::width() const { return COLS; }
int Painter::height() const { return LINES; }

void Painter::paint(const Canvas& canvas) {
  erase();
  std::string run;
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width();) {
      const Style style = canvas.at(x, y).style;
      const int begin = x;
      run.clear();
      for (; x < canvas.width() && canvas.at(x, y).style == style; ++x) {
        const char32_t glyph = canvas.at(x, y).glyph;
        run += unicode_ ? to_utf8(glyph) : std::string(1, ascii(glyph));
      }
      attrset(static_cast<int>(attributes(style)));
      mvaddstr(y, begin, run.c_str());
    }
  }
  refresh();
}

std::optional<KeyPress> Painter::key(int timeout_ms) {
  timeout(timeout_ms);
  const int code = getch();
  constexpr int kEscape = 27;
  constexpr int kDelete = 127;
  switch (code) {
    case ERR:
    case KEY_RESIZE:
      return {};
    case KEY_UP:
      return KeyPress{Key::up};
    case KEY_DOWN:
      return KeyPress{Key::down};
    case KEY_PPAGE:
      return KeyPress{Key::page_up};
    case KEY_NPAGE:
      return KeyPress{Key::page_down};
    case KEY_HOME:
      return KeyPress{Key::home};
    case KEY_END:
      return KeyPress{Key::end};
    case KEY_RIGHT:
    case KEY_ENTER:
    case '\r':
    case '\n':
      return KeyPress{Key::enter};
    case KEY_LEFT:
    case kEscape:
      return KeyPress{Key::back};
    case KEY_BACKSPACE:
    case kDelete:
    case '\b':
      return KeyPress{Key::erase};
    default:
      break;
  }
  if (code < ' ' || code >= kDelete) return {};
  return KeyPress{Key::character, static_cast<char>(code)};
}

}  // namespace marco::spy
