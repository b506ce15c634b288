#include "lcm_tools/procman/process/output_view.hpp"

#include <algorithm>

#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {

void OutputView::toggle_events() {
  shows_events_ = !shows_events_;
  scroll_to_end();
}

void OutputView::scroll(int pages) {
  scrolled_lines_ = std::max(scrolled_lines_ + pages * std::max(height_ - 1, 1), 0);
}

const std::deque<std::string>& OutputView::lines_of(const TableRow* chosen) const {
  const bool command = chosen != nullptr && !chosen->is_group;
  return shows_events_ || !command ? sheriff_.log().events()
                                   : sheriff_.log().output(chosen->target);
}

std::vector<std::string> OutputView::hints() const {
  std::string scripts;
  for (const ScriptConfig& script : sheriff_.config().scripts) {
    if (scripts.size() < 100) scripts += (scripts.empty() ? "" : ", ") + script.name;
  }
  std::vector<std::string> lines = {"nothing yet"};
  lines.push_back(scripts.empty() ? "the file has no scripts; s starts the chosen command"
                                  : "R runs a script of the file (" + scripts +
                                        "), s starts the chosen command");
  lines.emplace_back("Space is the emergency stop of all bases; ? shows all keys");
  return lines;
}

std::vector<std::string> OutputView::window(const std::deque<std::string>& all, int height) {
  // From the end, only as far as needed: there may be megabytes.
  const auto wanted = static_cast<std::size_t>(height) + static_cast<std::size_t>(scrolled_lines_);
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

void OutputView::draw(const TableRow* chosen, int rows_below, int top, int height) {
  height_ = height;
  const std::deque<std::string>& all = lines_of(chosen);
  const std::vector<std::string> lines = window(all, height);
  std::string title = &all == &sheriff_.log().events() ? " events" : " output of " + chosen->target;
  if (scrolled_lines_ > 0) title += format(", %d lines up", scrolled_lines_);
  const std::string more = rows_below > 0 ? format("%d more rows below ", rows_below) : "";
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
