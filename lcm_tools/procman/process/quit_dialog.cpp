// Asks what becomes of the commands that still run, and waits for them to stop.
#include <algorithm>
#include <optional>

#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/dialog.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kStoppingUs = 20'000'000;
constexpr int kBoxWidth = 64;
constexpr std::size_t kMostLines = 8;

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

std::unique_ptr<Dialog> quit_dialog(ScreenContext& context) {
  return std::make_unique<QuitDialog>(context);
}

}  // namespace marco::procman
