#pragma once

#include <deque>
#include <string>
#include <vector>

#include "lcm_tools/procman/command_table.hpp"
#include "lcm_tools/procman/process/sheriff_process.hpp"

namespace marco::procman {

/// The lower half of the screen: the output of the chosen command, or the event log.
class OutputView {
 public:
  explicit OutputView(const SheriffProcess& sheriff) : sheriff_(sheriff) {}

  void toggle_events();
  void scroll(int pages);
  void scroll_to_end() { scrolled_lines_ = 0; }

  /// @param rows_below  rows of the table that do not fit above: noted in the title.
  void draw(const TableRow* chosen, int rows_below, int top, int height);

 private:
  const std::deque<std::string>& lines_of(const TableRow* chosen) const;
  std::vector<std::string> window(const std::deque<std::string>& all, int height);
  std::vector<std::string> hints() const;

  const SheriffProcess& sheriff_;
  bool shows_events_ = false;
  int scrolled_lines_ = 0;  ///< up from the end
  int height_ = 1;
};

}  // namespace marco::procman
