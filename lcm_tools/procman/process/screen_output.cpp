// The lower half of the screen: output, events, and what to do where there is neither.
#include <algorithm>

// Else its macros rename our members.
#define NCURSES_NOMACROS
#include <curses.h>

#include "lcm_tools/procman/process/screen.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {

const std::deque<std::string>& Screen::shown_lines() const {
  const bool command = chosen_ < static_cast<int>(rows_.size()) &&
                       !rows_[static_cast<std::size_t>(chosen_)].is_group;
  return shows_events_ || !command ? sheriff_.events() : sheriff_.output().lines(chosen_target_);
}

std::string Screen::output_title() const {
  if (&shown_lines() == &sheriff_.events()) return "events";
  return "output of " + chosen_target_;
}

std::vector<std::string> Screen::hints() const {
  std::string scripts;
  for (const ScriptConfig& script : sheriff_.config().scripts) {
    if (scripts.size() < 100) scripts += (scripts.empty() ? "" : ", ") + script.name;
  }
  return {"nothing yet",
          scripts.empty()
              ? "the file has no scripts; s starts the chosen command"
              : "R runs a script of the file (" + scripts + "), s starts the chosen command",
          "Space is the emergency stop of all bases; ? shows all keys"};
}

std::vector<std::string> Screen::output_window(int height) {
  // From the end, as far as needed: there may be megabytes.
  const std::deque<std::string>& all = shown_lines();
  const auto wanted = static_cast<std::size_t>(height + scrolled_lines_);
  std::vector<std::string> reversed;
  std::size_t at = all.size();
  if (at > 0 && all.back().empty()) --at;
  if (at == 0) return hints();
  while (at > 0 && reversed.size() < wanted) {
    const std::vector<std::string> pieces = wrapped(printable(all[--at]), std::max(COLS, 2));
    reversed.insert(reversed.end(), pieces.rbegin(), pieces.rend());
  }
  const int count = static_cast<int>(reversed.size());
  if (at == 0) scrolled_lines_ = std::clamp(scrolled_lines_, 0, std::max(count - height, 0));
  const int last = count - scrolled_lines_;
  std::vector<std::string> window;
  for (int i = std::max(last - height, 0); i < last; ++i) {
    window.push_back(reversed[static_cast<std::size_t>(count - 1 - i)]);
  }
  return window;
}

void Screen::draw_output(int top, int height) {
  const std::vector<std::string> lines = output_window(height);
  std::string title = " " + output_title();
  if (scrolled_lines_ > 0) title += format(", %d lines up", scrolled_lines_);
  const int below = static_cast<int>(rows_.size()) - first_row_ - table_height_;
  const std::string more = below > 0 ? format("%d more rows below ", below) : "";
  const int more_width = width_of(more);
  attron(A_REVERSE);
  put(top, 0, title, COLS - more_width);
  put(top, COLS - more_width, more, more_width);
  attroff(A_REVERSE);
  for (int i = 0; i < height && i < static_cast<int>(lines.size()); ++i) {
    put(top + 1 + i, 0, lines[static_cast<std::size_t>(i)], COLS);
  }
}

}  // namespace marco::procman
