#include "lcm_tools/procman/process/command_list.hpp"

#include <algorithm>

#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {

void CommandList::refresh(const SheriffState& sheriff, int64_t now_us) {
  rows_ = table_rows(sheriff, folded_, now_us);
  const auto chosen = std::find_if(rows_.begin(), rows_.end(), [this](const TableRow& row) {
    return row.target == chosen_target_;
  });
  if (chosen != rows_.end()) chosen_ = static_cast<int>(chosen - rows_.begin());
  move(0);
}

const TableRow* CommandList::chosen() const {
  return chosen_ < size() ? &rows_[static_cast<std::size_t>(chosen_)] : nullptr;
}

void CommandList::move(int rows) {
  chosen_ = std::clamp(chosen_ + rows, 0, std::max(size() - 1, 0));
  if (chosen() != nullptr) chosen_target_ = chosen()->target;
}

void CommandList::fold() {
  if (chosen() != nullptr && chosen()->is_group) folded_.insert(chosen_target_);
}

void CommandList::unfold() { folded_.erase(chosen_target_); }

void CommandList::draw(int top, int height) {
  height_ = height;
  const int id_width = std::clamp(COLS / 4, 12, 32);
  attron(A_BOLD);
  put(top, 0, "Id", id_width);
  put(top, id_width, " Deputy", 13);
  put(top, id_width + 13, " Status", 16);
  put(top, id_width + 29, " CPU %    Mem kB  Command", COLS - id_width - 29);
  attroff(A_BOLD);
  if (chosen_ < first_row_) first_row_ = chosen_;
  if (chosen_ >= first_row_ + height) first_row_ = chosen_ - height + 1;
  first_row_ = std::clamp(first_row_, 0, std::max(size() - height, 0));
  if (first_row_ > 0) {
    const std::string more = format(" %d more above", first_row_);
    put(top, COLS - width_of(more), more, width_of(more));
  }
  for (int i = first_row_; i < std::min(first_row_ + height, size()); ++i) {
    draw_row(top + 1 + i - first_row_, rows_[static_cast<std::size_t>(i)],
             i == chosen_ ? A_REVERSE : A_NORMAL);
  }
}

void CommandList::draw_row(int y, const TableRow& row, int attributes) const {
  const int id_width = std::clamp(COLS / 4, 12, 32);
  const std::string mark = row.is_group ? (row.folded ? "+ " : "- ") : "  ";
  attron(attributes | (row.is_group ? A_BOLD : A_NORMAL));
  put(y, 0, std::string(static_cast<std::size_t>(row.depth) * 2, ' ') + mark + row.name, id_width);
  attroff(A_BOLD);
  put(y, id_width, " " + row.deputy, 13);
  attroff(attributes);
  const int colour = COLOR_PAIR(static_cast<int>(row.colour));
  attron(colour);
  put(y, id_width + 13, " " + row.status, 16);
  attroff(colour);
  const auto rss_kb = static_cast<long long>(row.rss_bytes / 1024);
  put(y, id_width + 29, format(" %5.1f %9lld  ", row.cpu_usage * 100.0, rss_kb) + row.exec,
      COLS - id_width - 29);
}

}  // namespace marco::procman
