#include <chrono>
#include <cstdio>
#include <optional>

#include "common/pose2.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/process_status_t.hpp"
#include "marco/slam_command_t.hpp"
#include "slam/process/slam_answers.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using std::chrono::steady_clock;

// A large map takes seconds to be written, and a search in one some, too.
constexpr std::chrono::seconds kPatience{10};
// Each SLAM that runs says so once a second.
constexpr std::chrono::milliseconds kAllAreHeard{1300};

/// Sends orders to all running SLAMs, and receives their answers.
class OrderGiver {
 public:
  explicit OrderGiver(const std::string& lcm_url) : bus_(lcm_url) {
    bus_.subscribe<slam_reply_t>(channels::kSlamReply, drops_,
                                 [this](const slam_reply_t& reply, const auto&) {
                                   if (answers_) answers_->take(reply);
                                 });
    bus_.subscribe<process_status_t>(channels::kProcessStatus, drops_,
                                     [this](const process_status_t& status, const auto&) {
                                       if (answers_ && slam::is_slam(status.process))
                                         answers_->expect(status.process);
                                     });
  }

  /// Prints the answers. An order without one is not sent again: it may have been obeyed.
  /// @returns the exit code.
  int give(slam_command_t command) {
    command.utime = process::wall_clock_us();
    answers_.emplace(command);
    bus_.publish(channels::kSlamCommand, command);
    const auto begin = steady_clock::now();
    while (steady_clock::now() < begin + kPatience && !process::stop_requested()) {
      bus_.handle_once(50);
      if (answers_->are_complete() && steady_clock::now() > begin + kAllAreHeard) break;
    }
    if (answers_->is_empty()) {
      std::fputs("marco slam: no SLAM answers. Is marco-slam running, on this network?\n", stderr);
      return process::kExitFailed;
    }
    print(answers_->are_good() ? stdout : stderr, "%s\n", answers_->text().c_str());
    return answers_->are_good() ? process::kExitDone : process::kExitFailed;
  }

 private:
  process::LcmBus bus_;
  process::DropCounter drops_;
  std::optional<slam::SlamAnswers> answers_;  ///< to the newest order
};

void take_pose(const std::vector<double>& x_y_deg, slam_command_t& command) {
  command.x_m = x_y_deg[0];
  command.y_m = x_y_deg[1];
  command.theta_rad = deg_to_rad(x_y_deg[2]);
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-slam-order", [&] {
    process::CommandLine app(
        "Sends an order to every running SLAM, and reports the results.\n"
        "NAME is a folder below the SLAM's own folder for maps (maps_folder in its config).");
    std::string lcm_url, folder;
    std::vector<double> pose;
    slam_command_t command = {};
    process::add_lcm_url(app, lcm_url);
    app.require_subcommand();
    const auto order = [&](const char* word, int8_t code, const char* help) {
      return app.add_subcommand(word, help, [&command, code] { command.command = code; });
    };
    const auto named = [&](process::CommandLine sub) {
      sub.add_option("NAME", folder, "of the map").required();
      return sub;
    };
    const auto posed = [&](process::CommandLine sub, const char* name, const char* help) {
      return sub.add_option(name, pose, help).values(3).value_name("X Y DEG");
    };
    named(order("save", slam_command_t::SAVE, "write map and path into the folder NAME"));
    posed(named(order("localize", slam_command_t::LOCALIZE,
                      "find the robot in the map NAME, without changing it")),
          "--at", "its pose [m, m, degrees], if known");
    named(
        order("extend", slam_command_t::EXTEND, "add what is driven from now on to the map NAME"));
    order("reset", slam_command_t::RESET, "discard the map and begin a new one here");
    posed(
        order("set-pose", slam_command_t::SET_POSE,
              "the robot is here: tracks from there when localizing, else begins a new map there"),
        "POSE", "[m, m, degrees]")
        .required();
    order("pause", slam_command_t::PAUSE, "ignore scans until resume");
    order("resume", slam_command_t::RESUME, "map again after pause");
    if (const auto code = app.parse(argc, argv)) return *code;
    process::catch_stop_signals();
    OrderGiver giver(lcm_url);
    command.folder = folder;
    if (!pose.empty()) take_pose(pose, command);
    const int code = giver.give(command);
    if (code != process::kExitDone || command.command != slam_command_t::LOCALIZE || pose.empty()) {
      return code;
    }
    command.command = slam_command_t::SET_POSE;
    return giver.give(command);
  });
}
