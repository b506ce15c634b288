#include "lcm_tools/procman/process/screen.hpp"

#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

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

void ScreenContext::say(const std::string& text) {
  notice = text;
  notice_until_us = monotonic_us() + kNoticeUs;
}

Screen::Screen(SheriffProcess& sheriff, const ScreenOptions& options)
    : context_{sheriff, options.is_lone, options.config_path}, output_(sheriff) {
  if (isatty(STDIN_FILENO) == 0 || isatty(STDOUT_FILENO) == 0) {
    throw std::runtime_error("this is not a terminal; to run without a screen: -n SCRIPT");
  }
  std::setlocale(LC_ALL, "");
  if (MB_CUR_MAX == 1) std::setlocale(LC_CTYPE, "C.UTF-8");
  terminal_ = newterm(nullptr, stdout, stdin);
  if (terminal_ == nullptr) {
    throw std::runtime_error(
        "the terminal's type (TERM) is unknown; to run without a screen: -n SCRIPT");
  }
  raw();  // ^S and ^Q are keys here
  noecho();
  keypad(stdscr, TRUE);
  nodelay(stdscr, TRUE);
  set_escdelay(25);
  curs_set(0);
  define_colours();
  const auto& events = sheriff.log().events();
  const auto warnings = std::count_if(events.begin(), events.end(), [](const std::string& event) {
    return event.find("warning: ") != std::string::npos;
  });
  if (warnings > 0)
    context_.say(std::to_string(warnings) + " warnings about the file: e shows them");
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
  if (context_.sheriff.take_other_sheriff_seen()) {
    context_.sheriff.state().set_observer(true);
    context_.say("another sheriff is active: now only watching; o = give orders again");
  }
  if (dialog_) dialog_->on_time();
  if (keys || monotonic_us() - drawn_us_ >= kDrawPeriodUs) draw();
}

void Screen::on_key(int key) {
  const bool types = dialog_ && dialog_->takes_text();
  if (!types && on_emergency_key(key)) return;
  const bool quits = key == control('q') || key == control('c');
  if (quits && !(dialog_ && dialog_->takes_quit_keys())) return ask_to_quit();
  if (dialog_) {
    if (dialog_->on_key(key) == Dialog::After::closes) dialog_.reset();
    if (!context_.chosen_command.empty()) list_.choose(std::exchange(context_.chosen_command, {}));
    return;
  }
  const auto at = table_keys().find(key);
  if (at != table_keys().end()) at->second(*this);
}

const Screen::Keys& Screen::table_keys() {
  static const Keys kKeys = [] {
    Keys all;
    const auto bind = [&all](std::initializer_list<int> codes, const Keys::mapped_type& action) {
      for (const int code : codes) all[code] = action;
    };
    bind({'q'}, [](Screen& s) { s.ask_to_quit(); });
    bind({KEY_UP, 'k'}, [](Screen& s) { s.move(-1); });
    bind({KEY_DOWN, 'j'}, [](Screen& s) { s.move(1); });
    bind({KEY_LEFT, 'h'}, [](Screen& s) { s.list_.fold(); });
    bind({KEY_RIGHT, 'l'}, [](Screen& s) { s.list_.unfold(); });
    bind({KEY_PPAGE}, [](Screen& s) { s.output_.scroll(1); });
    bind({KEY_NPAGE}, [](Screen& s) { s.output_.scroll(-1); });
    bind({KEY_END}, [](Screen& s) { s.output_.scroll_to_end(); });
    bind({'e'}, [](Screen& s) { s.output_.toggle_events(); });
    bind({'s', control('s')}, [](Screen& s) { s.order(Order::start); });
    bind({'t', control('t')}, [](Screen& s) { s.order(Order::stop); });
    bind({'r', control('r')}, [](Screen& s) { s.order(Order::restart); });
    bind({'a'}, [](Screen& s) { s.context_.sheriff.script().abort(); });
    bind({'o'}, [](Screen& s) {
      SheriffState& state = s.context_.sheriff.state();
      if (s.context_.sheriff.script().is_running())
        return s.context_.say("a script is running: a = abort it");
      state.set_observer(!state.observer());
    });
    bind({'n'}, [](Screen& s) { s.open_new_form(); });
    bind({control('e')}, [](Screen& s) { s.open_edit_form(); });
    bind({KEY_DC}, [](Screen& s) { s.remove_chosen(); });
    bind({'R'}, [](Screen& s) { s.dialog_ = script_dialog(s.context_); });
    bind({'w'}, [](Screen& s) { s.dialog_ = save_dialog(s.context_); });
    bind({'d'}, [](Screen& s) { s.dialog_ = deputies_dialog(s.context_.sheriff); });
    bind({'?'}, [](Screen& s) { s.dialog_ = help_dialog(); });
    return all;
  }();
  return kKeys;
}

bool Screen::on_emergency_key(int key) {
  if (key != ' ' && key != 'U') return false;
  const bool engage = key == ' ';
  try {
    context_.sheriff.emergency_stop().order(
        engage ? EmergencyStop::Order::engage : EmergencyStop::Order::release, monotonic_us());
    context_.sheriff.log().note(engage ? "EMERGENCY STOP sent: all bases stop; U releases them"
                                       : "the emergency stop is released");
    if (!engage) context_.say("the emergency stop is released");
  } catch (const std::runtime_error& failure) {
    context_.say(std::string("EMERGENCY STOP is not sent yet, trying again: ") + failure.what());
  }
  return true;
}

void Screen::ask_to_quit() {
  // An observer does not decide what runs.
  const SheriffState& state = context_.sheriff.state();
  if (state.running().empty() || (state.observer() && !context_.is_lone)) {
    context_.wants_to_end = true;
  } else {
    dialog_ = quit_dialog(context_);
  }
}

void Screen::order(Order order) {
  SheriffState& state = context_.sheriff.state();
  if (state.observer()) return context_.say("only watching; o = give orders");
  // A stop is never refused; the script's own waits notice it.
  if (context_.sheriff.script().is_running() && order != Order::stop) {
    return context_.say("a script is running: a = abort it; t stops the command");
  }
  const TableRow* row = list_.chosen();
  if (row == nullptr) return;
  const Target target = {row->is_group ? TargetKind::group : TargetKind::command, row->target};
  // A row is one command, though others may bear its label.
  const auto ids =
      row->is_group ? state.commands_of(target) : std::vector<std::string>{row->target};
  for (const std::string& id : ids) {
    if (order == Order::start) state.start(id);
    if (order == Order::stop) state.stop(id);
    if (order == Order::restart) state.restart(id);
  }
  constexpr const char* kWords[] = {"start ", "stop ", "restart "};
  context_.sheriff.log().note(kWords[static_cast<int>(order)] + target.text());
}

void Screen::open_new_form() {
  const auto& deputies = context_.sheriff.state().deputies();
  const TableRow* row = list_.chosen();
  const std::string group = row != nullptr && row->is_group ? row->target : "";
  dialog_ = form_dialog(
      context_, CommandForm(deputies.empty() ? "localhost" : deputies.begin()->first, group));
}

void Screen::open_edit_form() {
  const TableRow* row = list_.chosen();
  if (row == nullptr || row->is_group) return context_.say("choose a command to edit");
  for (const PlacedCommand& placed : all_commands(context_.sheriff.config())) {
    if (placed.command.id != row->target) continue;
    dialog_ = form_dialog(context_, CommandForm(placed));
    return;
  }
  context_.say(row->target + " is not in our file: its deputy reported it");
}

void Screen::remove_chosen() {
  const TableRow* row = list_.chosen();
  if (row == nullptr) return;
  if (row->is_group) return context_.say("choose a command to remove");
  const std::string id = row->target;
  if (std::exchange(removing_, id) != id) return context_.say("Del again removes " + id);
  removing_.clear();
  try {
    context_.sheriff.remove_command(id);
    context_.say("removed " + id);
  } catch (const std::exception& refused) {
    context_.say(refused.what());
  }
}

void Screen::move(int rows) {
  list_.move(rows);
  output_.scroll_to_end();
}

void Screen::draw() {
  drawn_us_ = monotonic_us();
  list_.refresh(context_.sheriff.state(), drawn_us_);
  erase();
  const int body = std::max(LINES - 4, 2);
  const int table_height = std::clamp(list_.size(), 1, std::max(body * 2 / 3, 1));
  draw_title();
  list_.draw(1, table_height);
  output_.draw(list_.chosen(), list_.rows_below(), table_height + 2, body - table_height);
  draw_bottom();
  if (dialog_ && !dialog_->lines().empty()) draw_box(dialog_->lines(), dialog_->chosen_line());
  refresh();
}

void Screen::draw_title() const {
  const std::string& stop = context_.sheriff.emergency_stop().engaged();
  if (!stop.empty()) {
    const int red = COLOR_PAIR(static_cast<int>(StatusColour::red)) | A_BOLD;
    attron(red);
    put(0, 0, " EMERGENCY STOP, U releases it; " + printable(stop), COLS);
    attroff(red);
    return;
  }
  const SheriffState& state = context_.sheriff.state();
  const std::string name = state.observer() ? " Procman Observer " : " Procman Sheriff ";
  std::string line = name, brief = name;
  for (const auto& [id, deputy] : state.deputies()) {
    line += "| " + deputy_text(id, deputy) + " ";
    brief += "| " + short_deputy_text(id, deputy) + " ";
  }
  if (width_of(line) > COLS) line = brief;
  if (width_of(line) > COLS) {
    line = name + format("| %zu deputies, d shows them", state.deputies().size());
  }
  if (state.deputies().empty()) line += "| no deputy yet ";
  attron(A_REVERSE);
  put(0, 0, printable(line), COLS);
  attroff(A_REVERSE);
}

void Screen::draw_bottom() const {
  std::string line = "R scripts  s start  t stop  r restart  Space EMERGENCY STOP  ? help  q quit";
  const std::string script = context_.sheriff.script().progress_text();
  if (!script.empty()) line = script + " (a = abort)";
  const std::string hint = dialog_ ? dialog_->hint() : "";
  if (!hint.empty()) line = hint;
  const bool types_here = dialog_ && dialog_->lines().empty();
  const bool notice = monotonic_us() < context_.notice_until_us && !types_here;
  if (notice) attron(A_BOLD | A_REVERSE);
  put(LINES - 1, 0, notice ? context_.notice : line, COLS - 1);
  if (notice) attroff(A_BOLD | A_REVERSE);
}

}  // namespace marco::procman
