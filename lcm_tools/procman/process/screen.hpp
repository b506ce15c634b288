#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "lcm_tools/procman/process/command_list.hpp"
#include "lcm_tools/procman/process/dialog.hpp"
#include "lcm_tools/procman/process/output_view.hpp"
#include "lcm_tools/procman/process/sheriff_process.hpp"

struct screen;  // of ncurses

namespace marco::procman {

struct ScreenOptions {
  std::string config_path;  ///< proposed for saving
  bool is_lone = false;     ///< the deputy ends with the sheriff, and all commands with it
};

/// The sheriff in a terminal: the table of commands above, the chosen command's output or the event
/// log below, dialogs over both. Owns the terminal while it lives.
class Screen {
 public:
  /// @param sheriff outlives the screen.
  /// @throws std::runtime_error when standard input and output are not a terminal.
  explicit Screen(SheriffProcess& sheriff, const ScreenOptions& options = {});
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// Handles keys, and draws when something may have changed.
  void step();

  bool wants_to_end() const { return context_.wants_to_end; }

 private:
  enum class Order { start, stop, restart };
  using Keys = std::map<int, std::function<void(Screen&)>>;

  static const Keys& table_keys();
  void on_key(int key);
  bool on_emergency_key(int key);
  void ask_to_quit();
  void order(Order order);
  void open_new_form();
  void open_edit_form();
  void remove_chosen();
  void move(int rows);
  void draw();
  void draw_title() const;
  void draw_bottom() const;

  ScreenContext context_;
  ::screen* terminal_ = nullptr;
  CommandList list_;
  OutputView output_;
  std::unique_ptr<Dialog> dialog_;
  std::string removing_;  ///< command that the user was asked about, once
  int64_t drawn_us_ = 0;
};

}  // namespace marco::procman
