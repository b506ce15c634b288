#include <chrono>
#include <cstdio>
#include <map>

#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/emergency_stop.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using process::EmergencyStop;
using std::chrono::steady_clock;

struct Arguments {
  process::CommonArguments common;
  bool release = false;
  std::string reason;
};

// A base without a device looks at its messages once a second, and every base tells its status
// twice a second: who has said nothing by then is not there.
constexpr std::chrono::milliseconds kListen{1500}, kPatience{4000}, kRepeat{100};

bool said_by_all(const std::map<std::string, bool>& bases) {
  return !bases.empty() &&
         std::all_of(bases.begin(), bases.end(), [](const auto& base) { return base.second; });
}

/// @returns by base whether it did what was asked.
std::map<std::string, bool> ask(process::LcmBus& bus, const Arguments& arguments) {
  std::map<std::string, bool> bases;
  process::DropCounter drops;
  bus.subscribe<base_status_t>(channels::kBaseStatus, drops,
                               [&](const base_status_t& message, const auto&) {
                                 const bool stopped = message.note.starts_with(kEmergencyStopNote);
                                 bases[message.base] = stopped != arguments.release;
                               });
  const EmergencyStop what = arguments.release ? EmergencyStop::release : EmergencyStop::engage;
  const auto begin = steady_clock::now();
  auto next = begin;
  while (!process::stop_requested()) {
    const auto now = steady_clock::now();
    if (now >= begin + kPatience || (now >= begin + kListen && said_by_all(bases))) break;
    if (now >= next) {
      next = now + kRepeat;
      process::send_emergency_stop(bus, what, "marco stop", arguments.reason);
    }
    bus.handle_once(20);
  }
  return bases;
}

int run(const Arguments& arguments) {
  process::catch_stop_signals();
  process::LcmBus bus(arguments.common.lcm_url);
  const std::map<std::string, bool> bases = ask(bus, arguments);
  const char* done = arguments.release ? "takes orders again" : "stopped, and stays stopped";
  const char* not_done = arguments.release ? "IS STILL STOPPED: its BASE_STATUS says why"
                                           : "DID NOT STOP: switch it off by hand";
  for (const auto& [base, did] : bases)
    print(stdout, "%s: %s\n", base.c_str(), did ? done : not_done);
  if (bases.empty()) {
    std::fputs(
        "marco stop: no base answers. Is its driver running, and on this network?\n"
        "            If a robot moves, switch it off by hand.\n",
        stderr);
  } else if (!arguments.release) {
    std::puts("marco stop --release lets it move again");
  }
  return said_by_all(bases) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-stop", [&] {
    process::CommandLine app(
        "Stops every base that hears it, and keeps it stopped until --release.\n"
        "Exit code 0: each base heard says that it did; 1: one did not, or none was heard");
    Arguments arguments;
    process::add_common_arguments(app, arguments.common);
    app.add_flag("--release", arguments.release, "lets the bases take orders again");
    app.add_option("--reason", arguments.reason, "one line for whoever wonders why it stands");
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(arguments);
  });
}
