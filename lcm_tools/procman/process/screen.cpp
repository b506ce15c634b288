#include "lcm_tools/procman/process/screen.hpp"

// Else its macros rename our members.
#define NCURSES_NOMACROS
#include <curses.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace marco::procman {
namespace {

constexpr int64_t kDrawPeriodUs = 100'000;
constexpr int64_t kNoticeUs = 6'000'000;

void define_colours() {
  if (!has_colors()) return;
  start_color();
  use_default_colors();
  const short orange = COLORS >= 256 ? 208 : COLOR_YELLOW;
  const short grey = COLORS >= 256 ? 246 : COLOR_WHITE;
  init_pair(static_cast<short>(StatusColour::orange), COLOR_BLACK, orange);
  init_pair(static_cast<short>(StatusColour::green), COLOR_BLACK, COLOR_GREEN);
  init_pair(static_cast<short>(StatusColour::yellow), COLOR_BLACK, COLOR_YELLOW);
  init_pair(static_cast<short>(StatusColour::red), COLOR_WHITE, COLOR_RED);
  init_pair(static_cast<short>(StatusColour::grey), COLOR_BLACK, grey);
}

}  // namespace

Screen::Screen(SheriffProcess& sheriff, ScreenOptions options)
    : sheriff_(sheriff), options_(std::move(options)), path_(options_.config_path) {
  if (isatty(STDIN_FILENO) == 0 || isatty(STDOUT_FILENO) == 0) {
    throw std::runtime_error("this is no terminal; without a screen: -n SCRIPT");
  }
  std::setlocale(LC_ALL, "");
  if (MB_CUR_MAX == 1) std::setlocale(LC_CTYPE, "C.UTF-8");
  terminal_ = newterm(nullptr, stdout, stdin);
  if (terminal_ == nullptr) {
    throw std::runtime_error("the terminal's kind (TERM) is unknown; without a screen: -n SCRIPT");
  }
  raw();  // ^S and ^Q are keys here
  noecho();
  keypad(stdscr, TRUE);
  nodelay(stdscr, TRUE);
  set_escdelay(25);
  curs_set(0);
  define_colours();
  const auto warns = [](const std::string& event) {
    return event.find("warning: ") != std::string::npos;
  };
  const auto warnings = std::count_if(sheriff_.events().begin(), sheriff_.events().end(), warns);
  if (warnings > 0) say(std::to_string(warnings) + " warnings about the file: e shows them");
  draw();
}

Screen::~Screen() {
  endwin();
  delscreen(terminal_);
}

void Screen::step() {
  bool keys = false;
  for (int key = getch(); key != ERR; key = getch()) {
    keys = true;
    on_key(key);
  }
  if (sheriff_.take_other_sheriff_seen()) {
    sheriff_.state().set_observer(true);
    say("another sheriff is at work: now only watching; o = give orders again");
  }
  end_when_stopped();
  if (keys || monotonic_us() - drawn_us_ >= kDrawPeriodUs) draw();
}

void Screen::on_key(int key) {
  const bool types = mode_ == Mode::form || mode_ == Mode::path;
  if (!types && on_emergency_key(key)) return;
  if (mode_ == Mode::quit) {
    on_quit_key(key);
  } else if (key == control('q') || key == control('c')) {
    ask_to_quit();
  } else if (mode_ == Mode::scripts) {
    on_scripts_key(key);
  } else if (mode_ == Mode::form) {
    on_form_key(key);
  } else if (mode_ == Mode::path) {
    on_path_key(key);
  } else if (mode_ == Mode::help || mode_ == Mode::deputies) {
    mode_ = Mode::table;
  } else {
    on_table_key(key);
  }
}

void Screen::on_table_key(int key) {
  switch (key) {
    case 'q':
      ask_to_quit();
      break;
    case 'd':
      mode_ = Mode::deputies;
      break;
    case KEY_UP:
    case 'k':
      move(-1);
      break;
    case KEY_DOWN:
    case 'j':
      move(1);
      break;
    case KEY_LEFT:
    case 'h':
      fold(true);
      break;
    case KEY_RIGHT:
    case 'l':
      fold(false);
      break;
    case KEY_PPAGE:
      scroll(1);
      break;
    case KEY_NPAGE:
      scroll(-1);
      break;
    case KEY_END:
      scrolled_lines_ = 0;
      break;
    case 'e':
      shows_events_ = !shows_events_;
      scrolled_lines_ = 0;
      break;
    case 'R':
      mode_ = Mode::scripts;
      break;
    case 'a':
      sheriff_.abort_script();
      break;
    case 'o':
      sheriff_.state().set_observer(!sheriff_.state().observer());
      break;
    case '?':
      mode_ = Mode::help;
      break;
    case 'n':
      open_form(false);
      break;
    case control('e'):
      open_form(true);
      break;
    case KEY_DC:
      remove_chosen();
      break;
    case 'w':
      mode_ = Mode::path;
      break;
    default:
      order(key);
  }
}

void Screen::order(int key) {
  const bool start = key == 's' || key == control('s');
  const bool stop = key == 't' || key == control('t');
  const bool restart = key == 'r' || key == control('r');
  if (!start && !stop && !restart) return;
  const ScriptRunner* script = sheriff_.script();
  const bool script_runs = script != nullptr && script->state() == ScriptRunner::State::running;
  if (sheriff_.state().observer()) return say("only watching; o = give orders");
  // A stop is never refused; the script's own waits notice it.
  if (script_runs && !stop) return say("a script is running: a = abort it; t stops the command");
  if (chosen_ >= static_cast<int>(rows_.size())) return;
  const TableRow& row = rows_[static_cast<std::size_t>(chosen_)];
  const Target target = {row.is_group ? TargetKind::group : TargetKind::command, row.target};
  // A row is one command, though others may bear its label.
  const auto ids =
      row.is_group ? sheriff_.state().commands_of(target) : std::vector<std::string>{row.target};
  for (const std::string& id : ids) {
    if (start) sheriff_.state().start(id);
    if (stop) sheriff_.state().stop(id);
    if (restart) sheriff_.state().restart(id);
  }
  sheriff_.note(std::string(start ? "start " : stop ? "stop " : "restart ") + target.text());
}

void Screen::on_scripts_key(int key) {
  const auto& scripts = sheriff_.config().scripts;
  const int last = static_cast<int>(scripts.size()) - 1;
  if (key == KEY_UP || key == 'k') chosen_script_ = std::max(chosen_script_ - 1, 0);
  if (key == KEY_DOWN || key == 'j') chosen_script_ = std::min(chosen_script_ + 1, last);
  if (key == 27 || key == 'q') mode_ = Mode::table;
  if (key != '\n' && key != '\r' && key != KEY_ENTER) return;
  mode_ = Mode::table;
  if (sheriff_.state().observer()) {
    say("only watching; o = give orders");
  } else if (chosen_script_ <= last) {
    try {
      sheriff_.run_script(scripts[static_cast<std::size_t>(chosen_script_)].name);
    } catch (const std::invalid_argument& refused) {
      sheriff_.note(refused.what());
      say("script \"" + scripts[static_cast<std::size_t>(chosen_script_)].name +
          "\" cannot be run: e shows why");
    }
  }
}

void Screen::say(const std::string& notice) {
  notice_ = notice;
  notice_until_us_ = monotonic_us() + kNoticeUs;
}

void Screen::move(int rows) {
  chosen_ = std::clamp(chosen_ + rows, 0, std::max(static_cast<int>(rows_.size()) - 1, 0));
  if (!rows_.empty()) chosen_target_ = rows_[static_cast<std::size_t>(chosen_)].target;
  scrolled_lines_ = 0;
}

void Screen::fold(bool folded) {
  if (chosen_ >= static_cast<int>(rows_.size())) return;
  const TableRow& row = rows_[static_cast<std::size_t>(chosen_)];
  if (!row.is_group) return;
  if (folded) {
    folded_.insert(row.target);
  } else {
    folded_.erase(row.target);
  }
}

void Screen::scroll(int pages) {
  scrolled_lines_ = std::max(scrolled_lines_ + pages * std::max(output_height_ - 1, 1), 0);
}

}  // namespace marco::procman
