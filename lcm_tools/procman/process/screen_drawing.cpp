// Else its macros rename our members.
#define NCURSES_NOMACROS
#include <curses.h>

#include <algorithm>

#include "lcm_tools/procman/process/screen.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kSilentTitleUs = 3'000'000;

double load_percent(const SheriffDeputy& deputy) { return deputy.machine.cpu_load * 100.0; }

std::string deputy_text(const std::string& id, const SheriffDeputy& deputy) {
  const double age_s = static_cast<double>(monotonic_us() - deputy.heard_us) * 1e-6;
  const double free_gb = static_cast<double>(deputy.machine.phys_mem_free_bytes) / 1e9;
  return id + format(": load %.0f %%, %.1f GB free, ", load_percent(deputy), free_gb) +
         format(age_s * 1e6 > kSilentTitleUs ? "SILENT for %.0f s" : "%.1f s ago", age_s);
}

const std::vector<std::string>& help_lines() {
  static const std::vector<std::string> lines = {
      "R        run a script        s ^S  start",
      "a        abort the script    t ^T  stop",
      "Space    EMERGENCY STOP      r ^R  restart",
      "U        release it          q ^Q  quit",
      "up down  choose              e     events or output",
      "right    open a group        d     the deputies",
      "left     close a group       o     observer on or off",
      "PgUp     older output        End   newest output",
      "PgDn     newer output",
      "n        new command         ^E    edit the command",
      "Del Del  remove the command  w     write the file",
      "s, t and r on a group mean all its commands."};
  return lines;
}

}  // namespace

void Screen::draw() {
  drawn_us_ = monotonic_us();
  rows_ = table_rows(sheriff_.state(), folded_, drawn_us_);
  // The choice stays on its command when rows come and go.
  const auto chosen = std::find_if(rows_.begin(), rows_.end(), [&](const TableRow& row) {
    return row.target == chosen_target_;
  });
  if (chosen != rows_.end()) chosen_ = static_cast<int>(chosen - rows_.begin());
  chosen_ = std::clamp(chosen_, 0, std::max(static_cast<int>(rows_.size()) - 1, 0));
  if (!rows_.empty()) chosen_target_ = rows_[static_cast<std::size_t>(chosen_)].target;
  erase();
  const int body = std::max(LINES - 4, 2);
  table_height_ = std::clamp(static_cast<int>(rows_.size()), 1, std::max(body * 2 / 3, 1));
  output_height_ = body - table_height_;
  draw_title();
  draw_table(1, table_height_);
  draw_output(table_height_ + 2, output_height_);
  draw_bottom();
  if (mode_ == Mode::help) draw_box(help_lines(), -1);
  if (mode_ == Mode::scripts) draw_scripts();
  if (mode_ == Mode::form) draw_form();
  if (mode_ == Mode::deputies) draw_deputies();
  if (mode_ == Mode::quit) draw_quit();
  refresh();
}

void Screen::draw_title() {
  const std::string& stop = sheriff_.emergency_stop().engaged();
  if (!stop.empty()) {
    const int red = COLOR_PAIR(static_cast<int>(StatusColour::red)) | A_BOLD;
    attron(red);
    put(0, 0, " EMERGENCY STOP, U releases it; " + printable(stop), COLS);
    attroff(red);
    return;
  }
  const std::string name = sheriff_.state().observer() ? " Procman Observer " : " Procman Sheriff ";
  const auto& deputies = sheriff_.state().deputies();
  std::string line = name;
  for (const auto& [id, deputy] : deputies) line += "| " + deputy_text(id, deputy) + " ";
  if (width_of(line) > COLS) {
    line = name;
    for (const auto& [id, deputy] : deputies) {
      const bool is_silent = monotonic_us() - deputy.heard_us > kSilentTitleUs;
      line += "| " + id + (is_silent ? " SILENT " : format(" %.0f %% ", load_percent(deputy)));
    }
  }
  if (width_of(line) > COLS) {
    line = name + format("| %zu deputies, d shows them", deputies.size());
  }
  if (deputies.empty()) line += "| no deputy was heard yet ";
  attron(A_REVERSE);
  put(0, 0, printable(line), COLS);
  attroff(A_REVERSE);
}

void Screen::draw_deputies() {
  std::vector<std::string> lines;
  for (const auto& [id, deputy] : sheriff_.state().deputies()) {
    lines.push_back(printable(deputy_text(id, deputy)));
  }
  if (lines.empty()) lines.emplace_back("no deputy was heard yet");
  draw_box(lines, -1);
}

void Screen::draw_table(int top, int height) {
  const int id_width = std::clamp(COLS / 4, 12, 32);
  attron(A_BOLD);
  put(top, 0, "Id", id_width);
  put(top, id_width, " Deputy", 13);
  put(top, id_width + 13, " Status", 16);
  put(top, id_width + 29, " CPU %    Mem kB  Command", COLS - id_width - 29);
  attroff(A_BOLD);
  if (chosen_ < first_row_) first_row_ = chosen_;
  if (chosen_ >= first_row_ + height) first_row_ = chosen_ - height + 1;
  first_row_ = std::clamp(first_row_, 0, std::max(static_cast<int>(rows_.size()) - height, 0));
  if (first_row_ > 0) {
    const std::string more = format(" %d more above", first_row_);
    put(top, COLS - width_of(more), more, width_of(more));
  }
  for (int i = 0; i < height && first_row_ + i < static_cast<int>(rows_.size()); ++i) {
    const int y = top + 1 + i;
    const TableRow& row = rows_[static_cast<std::size_t>(first_row_ + i)];
    const int chosen = first_row_ + i == chosen_ ? A_REVERSE : A_NORMAL;
    const std::string mark = row.is_group ? (row.folded ? "+ " : "- ") : "  ";
    attron(chosen | (row.is_group ? A_BOLD : A_NORMAL));
    put(y, 0, std::string(static_cast<std::size_t>(row.depth) * 2, ' ') + mark + row.name,
        id_width);
    attroff(A_BOLD);
    put(y, id_width, " " + row.deputy, 13);
    attroff(chosen);
    attron(COLOR_PAIR(static_cast<int>(row.colour)));
    put(y, id_width + 13, " " + row.status, 16);
    attroff(COLOR_PAIR(static_cast<int>(row.colour)));
    put(y, id_width + 29,
        format(" %5.1f %9lld  ", row.cpu_usage * 100.0,
               static_cast<long long>(row.rss_bytes / 1024)) +
            row.exec,
        COLS - id_width - 29);
  }
}

void Screen::draw_bottom() {
  std::string line = "R scripts  s start  t stop  r restart  Space EMERGENCY STOP  ? help  q quit";
  const ScriptRunner* script = sheriff_.script();
  if (script != nullptr && script->state() == ScriptRunner::State::running) {
    line = "script " + script->name() + " is running";
    if (!script->waiting_for().empty()) line += ", waits for " + script->waiting_for();
    line += " (a = abort)";
  }
  if (mode_ == Mode::path) line = "write the file (Enter, Esc): " + path_;
  if (mode_ == Mode::form) line = "Enter or Down: next field   ^S: done   Esc: leave it";
  const bool notice = monotonic_us() < notice_until_us_ && mode_ != Mode::path;
  if (notice) attron(A_BOLD | A_REVERSE);
  put(LINES - 1, 0, notice ? notice_ : line, COLS - 1);
  if (notice) attroff(A_BOLD | A_REVERSE);
}

void Screen::draw_box(const std::vector<std::string>& lines, int chosen) {
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

void Screen::draw_form() {
  std::vector<std::string> lines;
  for (const CommandForm::Field& field : form_->fields()) {
    std::string line = format("%-18s ", field.name) + printable(field.text);
    if (&field == &form_->fields()[form_->chosen()]) line += "_";
    lines.push_back(line);
  }
  draw_box(lines, static_cast<int>(form_->chosen()));
}

void Screen::draw_scripts() {
  std::vector<std::string> names;
  for (const ScriptConfig& script : sheriff_.config().scripts) names.push_back(script.name);
  if (names.empty()) names.emplace_back("the file has no scripts");
  draw_box(names, chosen_script_);
}

}  // namespace marco::procman
