#include <poll.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdlib>

#include "lcm_tools/diagnosis/host.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "tools/bridge/lcm_side.hpp"
#include "tools/bridge/ros_side.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

constexpr const char* kTheirs = "udpm://239.255.76.67:7667?ttl=0";
constexpr const char* kOurs = "udpm://239.255.76.67:7668?ttl=0";
constexpr int kWaitMs = 50;

struct Arguments {
  process::CommonArguments common;
  std::string other = kTheirs;
};

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string counts_of(const bridge::MarcoSide& marco) {
  return std::to_string(marco.scans()) + " scans and " + std::to_string(marco.odometry()) +
         " odometry in, " + std::to_string(marco.poses()) + " poses and " +
         std::to_string(marco.maps()) + " maps out";
}

/// Until a signal comes. @param step  waits for messages from either side, and handles those of the
/// other one
void run_bridge(process::LcmBus& ours,
                process::DropCounter& drops,
                bridge::MarcoSide& marco,
                const std::function<void()>& step,
                const std::function<std::string()>& state) {
  process::StatusPublisher status(ours, "marco-bridge", drops);
  while (!process::stop_requested()) {
    if (!ours.waiting()) step();
    while (ours.handle_once(0)) {
    }
    marco.tick(steady_s());
    status.tick(state() + "; " + counts_of(marco));
  }
  spdlog::info("{}; {}; {}", state(), counts_of(marco), drops.summary());
}

void warn(const std::string& line) { spdlog::warn("{}", line); }
void say(const std::string& line) { spdlog::info("{}", line); }

void require_apart(const std::string& ours, const std::string& theirs) {
  if (!ours.starts_with("udpm:") || !theirs.starts_with("udpm:")) return;
  const auto a = diagnosis::parse_udp_url(ours), b = diagnosis::parse_udp_url(theirs);
  if (a.group != b.group || a.port != b.port) return;
  throw process::UsageError("Marco's programs and the others would share " + theirs +
                            ", where SLAM_POSE and LIDAR would carry two types: give Marco's "
                            "another one, e.g. LCM_DEFAULT_URL='" +
                            kOurs + "'");
}

int bridge_lcm(const Arguments& arguments, const ForeignTable& table) {
  const char* set = std::getenv("LCM_DEFAULT_URL");
  const bool is_given = !arguments.common.lcm_url.empty() || (set != nullptr && *set != '\0');
  const std::string url = is_given ? process::effective_lcm_url(arguments.common.lcm_url) : kOurs;
  require_apart(url, arguments.other);
  process::LcmBus ours(url), theirs(arguments.other);
  process::DropCounter drops(warn);
  bridge::LcmSide other(theirs, table, say);
  bridge::MarcoSide marco(ours, drops,
                          {[&other](const auto& pose) { other.send_pose(pose); },
                           [&other](const auto& map, Utime at) { other.send_map(map, at); },
                           [&other](const auto& path, Utime at) { other.send_path(path, at); }});
  other.connect(marco);
  spdlog::info("between {} (theirs) and {} (Marco's)", arguments.other, url);
  const auto step = [&] {
    pollfd files[] = {{ours.lcm().getFileno(), POLLIN, 0}, {theirs.lcm().getFileno(), POLLIN, 0}};
    if (!theirs.waiting()) poll(files, 2, kWaitMs);
    while (theirs.handle_once(0)) {
    }
  };
  run_bridge(ours, drops, marco, step, [&other] { return other.state(); });
  return process::kExitDone;
}

int bridge_ros(const Arguments& arguments, const ForeignTable& table) {
  process::LcmBus ours(arguments.common.lcm_url);
  process::DropCounter drops(warn);
  bridge::RosSide other(arguments.other, table.ros, drops, say);
  bridge::RosOutput& out = other.output();
  bridge::MarcoSide marco(ours, drops,
                          {[&out](const auto& pose) { out.send_pose(pose); },
                           [&out](const auto& map, Utime at) { out.send_map(map, at); },
                           [&out](const auto& path, Utime at) { out.send_path(path, at); }});
  other.connect(marco);
  spdlog::info("between {} and {} (Marco's)", arguments.other,
               process::effective_lcm_url(arguments.common.lcm_url));
  run_bridge(
      ours, drops, marco, [&] { other.step(ours.lcm().getFileno(), kWaitMs); },
      [&other] { return other.state(); });
  return process::kExitDone;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-bridge", [&] {
    process::CommandLine app(
        "Lets Marco map with another stack's robot: forwards its scans and odometry to Marco's "
        "programs, and returns pose, map and path.\n"
        "  marco-bridge                    MBot, dimos: LCM on the port 7667; Marco's programs on "
        "7668\n"
        "  marco-bridge ws://ROBOT:8765    ROS 1 or ROS 2 where foxglove_bridge runs; ROS is not "
        "needed here\n"
        "Its config is a table of channels and topics, as config/foreign.toml.");
    Arguments arguments;
    process::add_common_arguments(app, arguments.common);
    app.add_option("OTHER", arguments.other, "the other side: an LCM URL, or ws://HOST[:PORT]")
        .shows_default();
    if (const auto code = app.parse(argc, argv)) return *code;
    const auto table = process::load_options<ForeignTable>(arguments.common.config_path);
    if (process::prints_config(arguments.common, table)) return 0;
    process::start_logging("marco-bridge", arguments.common.log_level);
    process::catch_stop_signals();
    return arguments.other.starts_with("ws") ? bridge_ros(arguments, table)
                                             : bridge_lcm(arguments, table);
  });
}
