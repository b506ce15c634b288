#pragma once

#include <set>
#include <string>
#include <vector>

#include "lcm_tools/procman/command_table.hpp"

namespace marco::procman {

/// The upper half of the screen: the table of commands, scrolled so that the chosen row shows.
class CommandList {
 public:
  /// Takes over what the sheriff knows now. The choice stays on its command when rows come and go.
  void refresh(const SheriffState& sheriff, int64_t now_us);

  int size() const { return static_cast<int>(rows_.size()); }
  /// None when the table is empty.
  const TableRow* chosen() const;
  /// Chooses a command, from the next refresh() on.
  void choose(const std::string& id) { chosen_target_ = id; }
  void move(int rows);
  /// Of a chosen group: hides or shows its members.
  void fold();
  void unfold();

  void draw(int top, int height);
  /// Rows that did not fit below the last draw().
  int rows_below() const { return size() - first_row_ - height_; }

 private:
  void draw_row(int y, const TableRow& row, int attributes) const;

  std::vector<TableRow> rows_;
  std::set<std::string> folded_;
  int chosen_ = 0;
  std::string chosen_target_;
  int first_row_ = 0;
  int height_ = 1;
};

}  // namespace marco::procman
