// Makes or changes a command.
#include <stdexcept>
#include <utility>

#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/dialog.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {
namespace {

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

}  // namespace

std::unique_ptr<Dialog> form_dialog(ScreenContext& context, CommandForm form) {
  return std::make_unique<FormDialog>(context, std::move(form));
}

}  // namespace marco::procman
