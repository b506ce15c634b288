#include <chrono>
#include <cstdio>
#include <optional>
#include <utility>

#include "common/pose2.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/slam_command_t.hpp"
#include "marco/slam_reply_t.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using std::chrono::steady_clock;

// A large map takes seconds to be written, and a search in one some, too.
constexpr std::chrono::seconds kPatience{10};
// After a refusal, for the other SLAM's reply.
constexpr std::chrono::milliseconds kOthersReply{500};

/// Sends the order and waits for the reply. An order without a reply is not sent again: it may have
/// been obeyed. Where two SLAMs run, one may refuse what the other does.
std::optional<slam_reply_t> ask(process::LcmBus& bus, slam_command_t command) {
  command.utime = process::wall_clock_us();
  std::optional<slam_reply_t> answer;
  process::DropCounter drops;
  bus.subscribe<slam_reply_t>(channels::kSlamReply, drops, [&](const auto& reply, const auto&) {
    if (reply.command_utime == command.utime && (!answer || reply.ok)) answer = reply;
  });
  bus.publish(channels::kSlamCommand, command);
  auto end = steady_clock::now() + kPatience;
  bool was_refused = false;
  while (steady_clock::now() < end && !process::stop_requested()) {
    bus.handle_once(50);
    if (answer && answer->ok) break;
    if (answer && !std::exchange(was_refused, true)) end = steady_clock::now() + kOthersReply;
  }
  return answer;
}

/// Prints the answer. @returns the exit code.
int give(process::LcmBus& bus, const slam_command_t& command) {
  const std::optional<slam_reply_t> reply = ask(bus, command);
  if (!reply) {
    std::fputs("marco slam: no SLAM answers. Is marco-slam running, and on this network?\n",
               stderr);
    return process::kExitFailed;
  }
  std::fprintf(reply->ok ? stdout : stderr, "%s\n", reply->text.c_str());
  return reply->ok ? process::kExitDone : process::kExitFailed;
}

void take_pose(const std::vector<double>& x_y_deg, slam_command_t& command) {
  command.x_m = x_y_deg[0];
  command.y_m = x_y_deg[1];
  command.theta_rad = deg_to_rad(x_y_deg[2]);
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-slam-order", [&] {
    CLI::App app(
        "Gives an order to the running SLAM and says what became of it.\n"
        "NAME is a folder below the SLAM's own folder for maps (maps_folder in its config).");
    std::string lcm_url, folder;
    std::vector<double> pose;
    slam_command_t command = {};
    app.add_option("--lcm-url", lcm_url, "default: $LCM_DEFAULT_URL, else this host alone");
    app.require_subcommand(1);
    const auto order = [&](const char* word, int8_t code, const char* help) {
      auto* sub = app.add_subcommand(word, help);
      sub->callback([&command, code] { command.command = code; });
      return sub;
    };
    const auto named = [&](CLI::App* sub) {
      sub->add_option("NAME", folder, "of the map")->required();
      return sub;
    };
    const auto posed = [&](CLI::App* sub, const char* name, const char* help) {
      return sub->add_option(name, pose, help)->expected(3)->type_name("X Y DEG");
    };
    named(order("save", slam_command_t::SAVE, "write map and path into the folder NAME"));
    posed(named(order("localize", slam_command_t::LOCALIZE,
                      "find the robot in the map NAME, which stays as it is")),
          "--at", "where it is [m, m, degrees], when that is known");
    named(
        order("extend", slam_command_t::EXTEND, "add what is driven from now on to the map NAME"));
    order("reset", slam_command_t::RESET, "forget the map and begin a new one here");
    posed(
        order("set-pose", slam_command_t::SET_POSE,
              "the robot is here: tracks from there when localizing, else begins a new map there"),
        "POSE", "[m, m, degrees]")
        ->required();
    order("pause", slam_command_t::PAUSE, "ignore scans until resume");
    order("resume", slam_command_t::RESUME, "map again after pause");
    if (const auto code = process::parse_arguments(app, argc, argv)) return *code;
    process::catch_stop_signals();
    process::LcmBus bus(lcm_url);
    command.folder = folder;
    if (!pose.empty()) take_pose(pose, command);
    const int code = give(bus, command);
    if (code != process::kExitDone || command.command != slam_command_t::LOCALIZE || pose.empty()) {
      return code;
    }
    command.command = slam_command_t::SET_POSE;
    return give(bus, command);
  });
}
