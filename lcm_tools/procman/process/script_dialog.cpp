// Chooses a script of the file and runs it.
#include <algorithm>
#include <stdexcept>

#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/dialog.hpp"

namespace marco::procman {
namespace {

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

}  // namespace

std::unique_ptr<Dialog> script_dialog(ScreenContext& context) {
  return std::make_unique<ScriptDialog>(context);
}

}  // namespace marco::procman
