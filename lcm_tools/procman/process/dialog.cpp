#include "lcm_tools/procman/process/dialog.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <stdexcept>
#include <utility>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kSilentTitleUs = 3'000'000;
constexpr int64_t kStoppingUs = 20'000'000;
constexpr int kBoxWidth = 64;
constexpr std::size_t kMostLines = 8;

// Shows something: any key closes it.
class TextDialog : public Dialog {
 public:
  explicit TextDialog(std::function<std::vector<std::string>()> text) : text_(std::move(text)) {}

  After on_key(int /*key*/) override { return After::closes; }
  std::vector<std::string> lines() const override { return text_(); }

 private:
  std::function<std::vector<std::string>()> text_;
};

// Chooses a script of the file and runs it.
class ScriptDialog : public Dialog {
 public:
  explicit ScriptDialog(ScreenContext& context) : context_(context) {}

  After on_key(int key) override {
    const int last = static_cast<int>(scripts().size()) - 1;
    int& chosen = context_.chosen_script;
    if (key == KEY_UP || key == 'k') chosen = std::max(chosen - 1, 0);
    if (key == KEY_DOWN || key == 'j') chosen = std::min(chosen + 1, std::max(last, 0));
    if (key == kEscape || key == 'q') return After::closes;
    if (!is_enter(key)) return After::stays;
    if (context_.sheriff.state().observer()) {
      context_.say("only watching; o = give orders");
    } else if (chosen <= last) {
      run(scripts()[static_cast<std::size_t>(chosen)].name);
    }
    return After::closes;
  }

  std::vector<std::string> lines() const override {
    std::vector<std::string> names;
    for (const ScriptConfig& script : scripts()) names.push_back(script.name);
    if (names.empty()) names.emplace_back("the file has no scripts");
    return names;
  }
  int chosen_line() const override { return context_.chosen_script; }

 private:
  const std::vector<ScriptConfig>& scripts() const { return context_.sheriff.config().scripts; }

  void run(const std::string& name) {
    try {
      context_.sheriff.script().run(name);
    } catch (const std::invalid_argument& refused) {
      context_.sheriff.log().note(refused.what());
      context_.say("script \"" + name + "\" cannot be run: e shows the reason");
    }
  }

  ScreenContext& context_;
};

// Makes or changes a command.
class FormDialog : public Dialog {
 public:
  FormDialog(ScreenContext& context, CommandForm form)
      : context_(context), form_(std::move(form)) {}

  After on_key(int key) override {
    const bool last = form_.chosen() + 1 == form_.fields().size();
    if (key == kEscape) return After::closes;
    if (key == control('s') || (is_enter(key) && last)) return save();
    if (is_enter(key) || key == KEY_DOWN || key == '\t') {
      form_.move(1);
    } else if (key == KEY_UP || key == KEY_BTAB) {
      form_.move(-1);
    } else if (is_backspace(key)) {
      form_.erase();
    } else if (key == control('u')) {
      while (!form_.fields()[form_.chosen()].text.empty()) form_.erase();
    } else if (is_text(key)) {
      form_.type(static_cast<char>(key));
    }
    return After::stays;
  }

  std::vector<std::string> lines() const override {
    std::vector<std::string> lines;
    for (const CommandForm::Field& field : form_.fields()) {
      std::string line = format("%-18s ", field.name) + printable(field.text);
      if (&field == &form_.fields()[form_.chosen()]) line += "_";
      lines.push_back(line);
    }
    return lines;
  }
  int chosen_line() const override { return static_cast<int>(form_.chosen()); }
  std::string hint() const override { return "Enter or Down: next field   ^S: done   Esc: cancel"; }
  bool takes_text() const override { return true; }

 private:
  After save() {
    try {
      const PlacedCommand placed = form_.command();
      const std::string& id = placed.command.id;
      if (!form_.edits() && context_.sheriff.state().commands().contains(id)) {
        context_.say("there is a command " + id + " already");
        return After::stays;
      }
      context_.sheriff.put_command(placed);
      context_.chosen_command = id;
      return After::closes;
    } catch (const std::exception& refused) {
      context_.say(refused.what());
      return After::stays;
    }
  }

  ScreenContext& context_;
  CommandForm form_;
};

// Asks for a path, in the last line of the screen, and writes the file there.
class SaveDialog : public Dialog {
 public:
  explicit SaveDialog(ScreenContext& context) : context_(context) {}

  After on_key(int key) override {
    std::string& path = context_.config_path;
    if (key == kEscape) return After::closes;
    if (is_enter(key)) {
      save(path);
      return After::closes;
    }
    if (is_backspace(key) && !path.empty()) path.pop_back();
    if (key == control('u')) path.clear();
    if (is_text(key)) path += static_cast<char>(key);
    return After::stays;
  }

  std::vector<std::string> lines() const override { return {}; }
  std::string hint() const override {
    return "write the file (Enter, Esc): " + context_.config_path;
  }
  bool takes_text() const override { return true; }

 private:
  void save(const std::string& path) {
    try {
      files::write_whole_file(path, print_config(context_.sheriff.config()));
      context_.say("written: " + path);
    } catch (const std::exception& failed) {
      context_.say(failed.what());
    }
  }

  ScreenContext& context_;
};

// Asks what becomes of the commands that still run, and waits for them to stop.
class QuitDialog : public Dialog {
 public:
  explicit QuitDialog(ScreenContext& context) : context_(context) {}

  After on_key(int key) override {
    if (stopping_until_us_) {
      if (key == 'q' || key == control('q') || key == control('c')) context_.wants_to_end = true;
      return After::stays;
    }
    if (key == 'c' || key == kEscape) return After::closes;
    // A lone sheriff's deputy ends with it, and stops all commands.
    if (key == (context_.is_lone ? 'y' : 'n')) context_.wants_to_end = true;
    if (key == 'y' && !context_.is_lone) stop_all();
    return After::stays;
  }

  void on_time() override {
    if (!stopping_until_us_) return;
    if (context_.sheriff.state().running().empty() || monotonic_us() > *stopping_until_us_) {
      context_.wants_to_end = true;
    }
  }

  std::vector<std::string> lines() const override {
    std::vector<std::string> lines = {stopping_until_us_ ? "Waiting for these to stop:"
                                                         : "These still run:"};
    const int width = std::min(kBoxWidth, std::max(COLS - 6, 10));
    for (const std::string& line : wrapped(context_.sheriff.running_text(), width)) {
      if (lines.size() < kMostLines) lines.push_back("  " + line);
    }
    lines.emplace_back("");
    if (stopping_until_us_) {
      lines.emplace_back("q  quit at once");
      return lines;
    }
    if (context_.is_lone) {
      lines.emplace_back("y  stop them and quit (their deputy ends with this screen)");
    } else {
      lines.emplace_back("y  stop them and quit");
      lines.emplace_back("n  quit and leave them running");
    }
    lines.emplace_back("c  cancel");
    return lines;
  }
  bool takes_quit_keys() const override { return true; }

 private:
  void stop_all() {
    SheriffProcess& sheriff = context_.sheriff;
    sheriff.script().abort();
    for (const std::string& id : sheriff.state().running()) sheriff.state().stop(id);
    stopping_until_us_ = monotonic_us() + kStoppingUs;
  }

  ScreenContext& context_;
  std::optional<int64_t> stopping_until_us_;  ///< quits when all has stopped, or then
};

}  // namespace

std::string deputy_text(const std::string& id, const SheriffDeputy& deputy) {
  const int64_t age_us = monotonic_us() - deputy.heard_us;
  const double free_gb = static_cast<double>(deputy.machine.phys_mem_free_bytes) / 1e9;
  return id + format(": load %.0f %%, %.1f GB free, ", deputy.machine.cpu_load * 100.0, free_gb) +
         format(age_us > kSilentTitleUs ? "SILENT for %.0f s" : "%.1f s ago",
                static_cast<double>(age_us) * 1e-6);
}

std::string short_deputy_text(const std::string& id, const SheriffDeputy& deputy) {
  const bool is_silent = monotonic_us() - deputy.heard_us > kSilentTitleUs;
  return id + (is_silent ? " SILENT" : format(" %.0f %%", deputy.machine.cpu_load * 100.0));
}

std::unique_ptr<Dialog> help_dialog() {
  return std::make_unique<TextDialog>([] {
    return std::vector<std::string>{"R        run a script        s ^S  start",
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
  });
}

std::unique_ptr<Dialog> deputies_dialog(const SheriffProcess& sheriff) {
  return std::make_unique<TextDialog>([&sheriff] {
    std::vector<std::string> lines;
    for (const auto& [id, deputy] : sheriff.state().deputies()) {
      lines.push_back(printable(deputy_text(id, deputy)));
    }
    if (lines.empty()) lines.emplace_back("no deputy yet");
    return lines;
  });
}

std::unique_ptr<Dialog> script_dialog(ScreenContext& context) {
  return std::make_unique<ScriptDialog>(context);
}

std::unique_ptr<Dialog> form_dialog(ScreenContext& context, CommandForm form) {
  return std::make_unique<FormDialog>(context, std::move(form));
}

std::unique_ptr<Dialog> save_dialog(ScreenContext& context) {
  return std::make_unique<SaveDialog>(context);
}

std::unique_ptr<Dialog> quit_dialog(ScreenContext& context) {
  return std::make_unique<QuitDialog>(context);
}

}  // namespace marco::procman
