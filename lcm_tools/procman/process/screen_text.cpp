#include "lcm_tools/procman/process/screen_text.hpp"

#include <algorithm>
#include <cstdio>
#include <cwchar>

#include "lcm_tools/procman/process/curses.hpp"

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

void draw_box(const std::vector<std::string>& lines, int chosen) {
  std::size_t longest = 20;
  for (const std::string& line : lines) longest = std::max(longest, line.size());
  const int width = std::min(static_cast<int>(longest) + 4, COLS);
  const int height = std::min(static_cast<int>(lines.size()), std::max(LINES - 4, 1));
  const int first = std::clamp(chosen - height + 1, 0, static_cast<int>(lines.size()));
  const int left = std::max((COLS - width) / 2, 0);
  const int top = std::max((LINES - height - 2) / 2, 0);
  attron(A_REVERSE);
  put(top, left, "", width);
  put(top + height + 1, left, "", width);
  for (int i = 0; i < height; ++i) {
    const int at = first + i;
    if (at == chosen) attroff(A_REVERSE);
    put(top + 1 + i, left, "  " + lines[static_cast<std::size_t>(at)], width);
    attron(A_REVERSE);
  }
  attroff(A_REVERSE);
}

}  // namespace marco::procman
