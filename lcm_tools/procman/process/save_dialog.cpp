// Asks for a path, in the last line of the screen, and writes the file there.
#include <stdexcept>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/dialog.hpp"

namespace marco::procman {
namespace {

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

}  // namespace

std::unique_ptr<Dialog> save_dialog(ScreenContext& context) {
  return std::make_unique<SaveDialog>(context);
}

}  // namespace marco::procman
