#include "lcm_tools/procman/process/screen_text.hpp"

// Else its macros rename our members.
#define NCURSES_NOMACROS
#include <curses.h>

#include <algorithm>
#include <cstdio>
#include <cwchar>

namespace marco::procman {
namespace {

/// Calls `visit(character, its bytes, its width)` for each, until it returns false.
template <class Visit>
void for_each_character(const std::string& text, Visit&& visit) {
  std::mbstate_t state = {};
  for (std::size_t at = 0; at < text.size();) {
    wchar_t c = L'?';
    std::size_t size = std::mbrtowc(&c, text.data() + at, text.size() - at, &state);
    if (size == 0 || size > text.size() - at) {
      state = {};
      c = L'?';
      size = 1;
    }
    if (!visit(c, text.substr(at, size), std::max(wcwidth(c), 0))) return;
    at += size;
  }
}

}  // namespace

int width_of(const std::string& text) {
  int width = 0;
  for_each_character(text, [&](wchar_t, const std::string&, int columns) {
    width += columns;
    return true;
  });
  return width;
}

std::wstring fit(const std::string& text, int columns) {
  std::wstring out;
  int used = 0;
  for_each_character(text, [&](wchar_t c, const std::string&, int width) {
    if (used + width > columns) return false;
    used += width;
    out += c;
    return true;
  });
  out.append(static_cast<std::size_t>(std::max(columns - used, 0)), L' ');
  return out;
}

std::vector<std::string> wrapped(const std::string& text, int columns) {
  std::vector<std::string> lines(1);
  int used = 0;
  for_each_character(text, [&](wchar_t, const std::string& bytes, int width) {
    if (used + width > columns) {
      lines.emplace_back();
      used = 0;
    }
    used += width;
    lines.back() += bytes;
    return true;
  });
  return lines;
}

void put(int row, int column, const std::string& text, int columns) {
  if (columns > 0) mvaddwstr(row, column, fit(text, columns).c_str());
}

}  // namespace marco::procman
