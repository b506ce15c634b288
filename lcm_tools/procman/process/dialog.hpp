#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lcm_tools/procman/command_form.hpp"
#include "lcm_tools/procman/process/sheriff_process.hpp"

namespace marco::procman {

/// What the screen and its dialogs share.
struct ScreenContext {
  SheriffProcess& sheriff;
  bool is_lone = false;     ///< the deputy ends with the sheriff, and all commands with it
  std::string config_path;  ///< where to save: proposed, then as last typed
  int chosen_script = 0;
  std::string chosen_command{};  ///< set by the form: the command to be chosen in the table
  bool wants_to_end = false;
  std::string notice{};  ///< shown in the last line for some seconds
  int64_t notice_until_us = 0;

  void say(const std::string& text);
};

/// A box over the table that gets the keys until it is closed.
class Dialog {
 public:
  enum class After { stays, closes };

  virtual ~Dialog() = default;
  virtual After on_key(int key) = 0;
  /// Called at each step of the screen.
  virtual void on_time() {}
  /// The lines of the box; none = the dialog is only its hint.
  virtual std::vector<std::string> lines() const = 0;
  virtual int chosen_line() const { return -1; }
  /// Replaces the last line of the screen; "" = it stays.
  virtual std::string hint() const { return ""; }
  /// Whether keys are text: then Space is no emergency stop.
  virtual bool takes_text() const { return false; }
  /// Whether ^Q and ^C are the dialog's own.
  virtual bool takes_quit_keys() const { return false; }
};

std::unique_ptr<Dialog> help_dialog();
std::unique_ptr<Dialog> deputies_dialog(const SheriffProcess& sheriff);
std::unique_ptr<Dialog> script_dialog(ScreenContext& context);
std::unique_ptr<Dialog> form_dialog(ScreenContext& context, CommandForm form);
std::unique_ptr<Dialog> save_dialog(ScreenContext& context);
std::unique_ptr<Dialog> quit_dialog(ScreenContext& context);

/// "base: load 12 %, 16.6 GB free, 0.4 s ago", and in few columns "base 12 %".
std::string deputy_text(const std::string& id, const SheriffDeputy& deputy);
std::string short_deputy_text(const std::string& id, const SheriffDeputy& deputy);

}  // namespace marco::procman
