// Dialogs that only show something: any key closes them.
#include <utility>

#include "lcm_tools/procman/process/curses.hpp"
#include "lcm_tools/procman/process/dialog.hpp"
#include "lcm_tools/procman/process/screen_text.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kSilentTitleUs = 3'000'000;

class HelpDialog : public Dialog {
 public:
  After on_key(int /*key*/) override { return After::closes; }
  std::vector<std::string> lines() const override {
    static const std::vector<std::string> kLines = {
        "R        run a script        s ^S  start",
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
    return kLines;
  }
};

class DeputiesDialog : public Dialog {
 public:
  explicit DeputiesDialog(const SheriffProcess& sheriff) : sheriff_(sheriff) {}
  After on_key(int /*key*/) override { return After::closes; }
  std::vector<std::string> lines() const override {
    std::vector<std::string> lines;
    for (const auto& [id, deputy] : sheriff_.state().deputies()) {
      lines.push_back(printable(deputy_text(id, deputy)));
    }
    if (lines.empty()) lines.emplace_back("no deputy yet");
    return lines;
  }

 private:
  const SheriffProcess& sheriff_;
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

std::unique_ptr<Dialog> help_dialog() { return std::make_unique<HelpDialog>(); }

std::unique_ptr<Dialog> deputies_dialog(const SheriffProcess& sheriff) {
  return std::make_unique<DeputiesDialog>(sheriff);
}

}  // namespace marco::procman
