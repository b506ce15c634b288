// The screen's keys that stop things: the emergency stop, and the end with what still runs.
#include <stdexcept>

// Else its macros rename our members.
#define NCURSES_NOMACROS
#include <curses.h>

#include "lcm_tools/procman/process/screen.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kStoppingUs = 20'000'000;
constexpr int kBoxWidth = 64;

}  // namespace

bool Screen::on_emergency_key(int key) {
  if (key != ' ' && key != 'U') return false;
  const bool engage = key == ' ';
  try {
    sheriff_.emergency_stop().order(
        engage ? EmergencyStop::Order::engage : EmergencyStop::Order::release, monotonic_us());
    sheriff_.note(engage ? "EMERGENCY STOP sent: all bases stop; U releases them"
                         : "the emergency stop is released");
    if (!engage) say("the emergency stop is released");
  } catch (const std::runtime_error& failure) {
    say(std::string("EMERGENCY STOP is not sent yet, trying on: ") + failure.what());
  }
  return true;
}

void Screen::ask_to_quit() {
  // An observer has no say, and what runs is not its affair.
  if (sheriff_.state().running().empty() || (sheriff_.state().observer() && !options_.is_lone)) {
    wants_to_end_ = true;
  } else {
    mode_ = Mode::quit;
  }
}

void Screen::on_quit_key(int key) {
  if (stopping_until_us_) {
    if (key == 'q' || key == control('q') || key == control('c')) wants_to_end_ = true;
    return;
  }
  if (key == 'c' || key == 27) mode_ = Mode::table;
  if (key == 'n' && !options_.is_lone) wants_to_end_ = true;
  if (key != 'y') return;
  if (options_.is_lone) {
    wants_to_end_ = true;  // its deputy ends with it, and stops them all
    return;
  }
  sheriff_.abort_script();
  for (const std::string& id : sheriff_.state().running()) sheriff_.state().stop(id);
  stopping_until_us_ = monotonic_us() + kStoppingUs;
}

void Screen::end_when_stopped() {
  if (!stopping_until_us_) return;
  if (sheriff_.state().running().empty() || monotonic_us() > *stopping_until_us_) {
    wants_to_end_ = true;
  }
}

void Screen::draw_quit() {
  std::vector<std::string> lines = {stopping_until_us_ ? "Waits for these to stop:"
                                                       : "These still run:"};
  const int width = std::min(kBoxWidth, std::max(COLS - 6, 10));
  for (const std::string& line : wrapped(sheriff_.running_text(), width)) {
    if (lines.size() < 8) lines.push_back("  " + line);
  }
  lines.emplace_back("");
  if (stopping_until_us_) {
    lines.emplace_back("q  quit at once");
  } else if (options_.is_lone) {
    lines.emplace_back("y  stop them and quit (their deputy ends with this screen)");
  } else {
    lines.emplace_back("y  stop them and quit");
    lines.emplace_back("n  quit, they run on");
  }
  if (!stopping_until_us_) lines.emplace_back("c  cancel: go on here");
  draw_box(lines, -1);
}

}  // namespace marco::procman
