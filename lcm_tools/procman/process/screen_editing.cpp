// The screen's second half: commands are made, changed and removed, and the file is written.
// Else its macros rename our members.
#define NCURSES_NOMACROS
#include <curses.h>

#include <stdexcept>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/procman/process/screen.hpp"

namespace marco::procman {
namespace {

constexpr int kEscape = 27;
bool is_enter(int key) { return key == '\n' || key == '\r' || key == KEY_ENTER; }
bool is_backspace(int key) { return key == KEY_BACKSPACE || key == 127 || key == control('h'); }
bool is_text(int key) { return key >= ' ' && key < 256 && key != 127; }

}  // namespace

void Screen::open_form(bool edit) {
  const bool on_row = chosen_ < static_cast<int>(rows_.size());
  const TableRow* row = on_row ? &rows_[static_cast<std::size_t>(chosen_)] : nullptr;
  if (edit) {
    if (row == nullptr || row->is_group) return say("choose a command to edit");
    for (const PlacedCommand& placed : all_commands(sheriff_.config())) {
      if (placed.command.id == row->target) form_.emplace(placed);
    }
    if (!form_) return say(row->target + " is not of our file: it was found at its deputy");
  } else {
    const std::string deputy = sheriff_.state().deputies().empty()
                                   ? "localhost"
                                   : sheriff_.state().deputies().begin()->first;
    form_.emplace(deputy, row != nullptr && row->is_group ? row->target : "");
  }
  mode_ = Mode::form;
}

void Screen::on_form_key(int key) {
  const bool last = form_->chosen() + 1 == form_->fields().size();
  if (key == kEscape) {
    mode_ = Mode::table;
    form_.reset();
  } else if (key == control('s') || (is_enter(key) && last)) {
    save_form();
  } else if (is_enter(key) || key == KEY_DOWN || key == '\t') {
    form_->move(1);
  } else if (key == KEY_UP || key == KEY_BTAB) {
    form_->move(-1);
  } else if (is_backspace(key)) {
    form_->erase();
  } else if (key == control('u')) {
    while (!form_->fields()[form_->chosen()].text.empty()) form_->erase();
  } else if (is_text(key)) {
    form_->type(static_cast<char>(key));
  }
}

void Screen::save_form() {
  try {
    const PlacedCommand placed = form_->command();
    if (!form_->edits() && sheriff_.state().commands().contains(placed.command.id)) {
      return say("there is a command " + placed.command.id + " already");
    }
    sheriff_.put_command(placed);
    chosen_target_ = placed.command.id;
    mode_ = Mode::table;
    form_.reset();
  } catch (const std::exception& refused) {
    say(refused.what());
  }
}

void Screen::remove_chosen() {
  if (chosen_ >= static_cast<int>(rows_.size())) return;
  const TableRow& row = rows_[static_cast<std::size_t>(chosen_)];
  if (row.is_group) return say("choose a command to remove");
  if (removing_ != row.target) {
    removing_ = row.target;
    return say("Del again removes " + row.target);
  }
  removing_.clear();
  try {
    sheriff_.remove_command(row.target);
    say("removed " + std::string(row.target));
  } catch (const std::exception& refused) {
    say(refused.what());
  }
}

void Screen::on_path_key(int key) {
  if (key == kEscape) {
    mode_ = Mode::table;
  } else if (is_enter(key)) {
    mode_ = Mode::table;
    save_config();
  } else if (is_backspace(key)) {
    if (!path_.empty()) path_.pop_back();
  } else if (key == control('u')) {
    path_.clear();
  } else if (is_text(key)) {
    path_ += static_cast<char>(key);
  }
}

void Screen::save_config() {
  try {
    files::write_whole_file(path_, print_config(sheriff_.config()));
    say("written: " + path_);
  } catch (const std::exception& failed) {
    say(failed.what());
  }
}

}  // namespace marco::procman
