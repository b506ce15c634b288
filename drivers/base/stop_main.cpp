#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <utility>

#include "drivers/transport/wall_clock.hpp"
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
  bool forget_sensors = false;
  std::string reason;
};

// A base without a device looks at its messages once a second, and every base tells its status
// twice a second: who has said nothing by then is not there.
constexpr std::chrono::milliseconds kListen{1500}, kPatience{4000}, kRepeat{100};

/// By base: what it said of having done what was asked; "" = it has not yet.
using Answers = std::map<std::string, std::string>;

bool said_by_all(const Answers& bases) {
  return !bases.empty() && std::none_of(bases.begin(), bases.end(),
                                        [](const auto& base) { return base.second.empty(); });
}

/// @param say  asks; called again until all have answered.
/// @param answer_of  a status: "" = it is no answer.
Answers ask(process::LcmBus& bus,
            const std::function<void()>& say,
            const std::function<std::string(const base_status_t&)>& answer_of) {
  Answers bases;
  process::DropCounter drops;
  bus.subscribe<base_status_t>(
      channels::kBaseStatus, drops,
      [&](const base_status_t& message, const auto&) { bases[message.base] = answer_of(message); });
  const auto begin = steady_clock::now();
  auto next = begin;
  while (!process::stop_requested()) {
    const auto now = steady_clock::now();
    if (now >= begin + kPatience || (now >= begin + kListen && said_by_all(bases))) break;
    if (now >= next) {
      next = now + kRepeat;
      say();
    }
    bus.handle_once(20);
  }
  return bases;
}

int report(const Answers& bases, const char* not_done) {
  for (const auto& [base, said] : bases) {
    print(stdout, "%s: %s\n", base.c_str(), said.empty() ? not_done : said.c_str());
  }
  if (bases.empty()) {
    std::fputs(
        "marco stop: no base answers. Is its driver running, on this network?\n"
        "            If a robot moves, use its own switch.\n",
        stderr);
  }
  return said_by_all(bases) ? 0 : 1;
}

int stop(process::LcmBus& bus, const Arguments& arguments) {
  const bool release = arguments.release;
  const std::string done = release ? "takes orders again" : "stopped, and stays stopped";
  const Answers bases = ask(
      bus,
      [&] {
        process::send_emergency_stop(bus, release ? EmergencyStop::release : EmergencyStop::engage,
                                     "marco stop", arguments.reason);
      },
      [&](const base_status_t& status) {
        return status.note.starts_with(kEmergencyStopNote) != release ? done : "";
      });
  const int code = report(bases, release ? "IS STILL STOPPED: its BASE_STATUS gives the reason"
                                         : "DID NOT STOP: use its own switch");
  if (!bases.empty() && !release) std::puts("marco stop --release lets it move again");
  return code;
}

/// The first answer names the sensors: after it there are none to forget.
int forget_sensors(process::LcmBus& bus) {
  BaseCommand order;
  order.kind = BaseCommand::Kind::forget_sensors;
  order.id = drivers::wall_now().us;
  Answers first;
  const Answers bases = ask(
      bus,
      [&] {
        if (said_by_all(first)) return;
        order.utime = drivers::wall_now();
        bus.publish(channels::kBaseCommand, to_message(order));
      },
      [&](const base_status_t& status) {
        std::string& answer = first[status.base];
        if (answer.empty() && status.command_id == order.id) {
          answer = BaseNote(status.note).text;
        }
        return answer;
      });
  return report(bases, "does not know this order: its driver is older");
}

int run(const Arguments& arguments) {
  process::catch_stop_signals();
  process::LcmBus bus(arguments.common.lcm_url);
  return arguments.forget_sensors ? forget_sensors(bus) : stop(bus, arguments);
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-stop", [&] {
    process::CommandLine app(
        "Stops every base on the network, and keeps it stopped until --release.\n"
        "Exit code 0: each base confirmed it; 1: one did not, or none answered");
    Arguments arguments;
    process::add_common_arguments(app, arguments.common);
    app.add_flag("--release", arguments.release, "lets the bases take orders again");
    app.add_flag("--forget-sensors", arguments.forget_sensors,
                 "does not stop: the bases' obstacle guards forget lasers, sonars and their "
                 "mounts, after you removed or moved one");
    app.add_option("--reason", arguments.reason, "one line that explains the stop to others");
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(arguments);
  });
}
