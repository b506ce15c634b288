#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/procman/command_form.hpp"
#include "lcm_tools/procman/command_table.hpp"
#include "lcm_tools/procman/process/sheriff_process.hpp"

struct screen;  // of ncurses

namespace marco::procman {

/// The key code of Ctrl and a letter.
constexpr int control(char letter) { return letter & 0x1f; }

struct ScreenOptions {
  std::string config_path;  ///< proposed for saving
  bool is_lone = false;     ///< the deputy ends with the sheriff, and all commands with it
};

/// The sheriff in a terminal: the table of commands above, the chosen command's output or the event
/// log below. Owns the terminal while it lives.
class Screen {
 public:
  /// @param sheriff outlives the screen.
  /// @throws std::runtime_error when standard input and output are no terminal.
  explicit Screen(SheriffProcess& sheriff, ScreenOptions options = {});
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// Handles keys, and draws when something may have changed.
  void step();

  bool wants_to_end() const { return wants_to_end_; }

 private:
  enum class Mode { table, scripts, help, deputies, form, path, quit };

  void on_key(int key);
  void on_table_key(int key);
  void on_scripts_key(int key);
  void on_form_key(int key);
  void on_path_key(int key);
  void on_quit_key(int key);
  bool on_emergency_key(int key);
  void ask_to_quit();
  void end_when_stopped();
  void open_form(bool edit);
  void save_form();
  void save_config();
  void remove_chosen();
  void say(const std::string& notice);
  void order(int key);
  void move(int rows);
  void fold(bool folded);
  void scroll(int pages);
  void draw();
  void draw_title();
  void draw_table(int top, int height);
  void draw_output(int top, int height);
  void draw_bottom();
  void draw_box(const std::vector<std::string>& lines, int chosen);
  void draw_scripts();
  void draw_form();
  void draw_deputies();
  void draw_quit();
  const std::deque<std::string>& shown_lines() const;
  std::string output_title() const;
  std::vector<std::string> hints() const;
  std::vector<std::string> output_window(int height);

  SheriffProcess& sheriff_;
  ScreenOptions options_;
  ::screen* terminal_ = nullptr;
  std::vector<TableRow> rows_;
  std::set<std::string> folded_;
  int chosen_ = 0;
  std::string chosen_target_;
  int first_row_ = 0;
  int table_height_ = 1;
  int output_height_ = 1;
  int scrolled_lines_ = 0;  ///< up from the end of the output
  int chosen_script_ = 0;
  bool shows_events_ = false;
  bool wants_to_end_ = false;
  Mode mode_ = Mode::table;
  std::string notice_;
  int64_t notice_until_us_ = 0;
  std::optional<CommandForm> form_;
  std::string path_;                          ///< that is being typed
  std::string removing_;                      ///< asked once whether to remove it
  std::optional<int64_t> stopping_until_us_;  ///< quits when all has stopped, or then
  int64_t drawn_us_ = 0;
};

}  // namespace marco::procman
