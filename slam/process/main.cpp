#include <spdlog/spdlog.h>

#include <chrono>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "live/calibration_file.hpp"
#include "live/diagnosis/live_loop.hpp"
#include "live/foreign_bus.hpp"
#include "marco/process_status_t.hpp"
#include "slam/process/slam_adapter.hpp"

namespace {

/// Two would publish contradicting poses and maps. Messages for the other bus wait in its queue.
void require_alone(const std::string& url) {
  constexpr std::chrono::seconds kListen{2};  // PROCESS_STATUS comes once a second
  marco::process::LcmBus ear(url);
  marco::process::DropCounter drops;
  bool alone = true;
  ear.subscribe<marco::process_status_t>(
      marco::channels::kProcessStatus, drops,
      [&alone](const auto& status, auto&) { alone = alone && status.process != "marco-slam"; });
  const auto end = std::chrono::steady_clock::now() + kListen;
  while (alone && std::chrono::steady_clock::now() < end) ear.handle_once(50);
  if (!alone) throw std::runtime_error("another marco-slam is running on this network");
}

}  // namespace

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

int main(int argc, char** argv) {
  return process::run_main("marco-slam", [&] {
    process::CommandLine app(
        "Scan-matching SLAM: LIDAR and ODOMETRY in, SLAM_POSE, TRAJECTORY, LOOP_CLOSURES and "
        "GRID_MAP out");
    process::CommonArguments arguments;
    process::add_common_arguments(app, arguments);
    std::string checkpoint;
    app.add_option("--checkpoint", checkpoint, "overrides the config's checkpoint_path");
    std::string calibration;
    add_calibration_argument(app, calibration);
    std::string foreign_table;
    add_foreign_argument(app, foreign_table);
    if (const auto code = app.parse(argc, argv)) return *code;
    auto options = process::load_options<slam::SlamAdapterOptions>(arguments.config_path);
    if (!checkpoint.empty()) options.checkpoint_path = checkpoint;
    options.input.calibration = load_calibration(calibration);
    if (process::prints_config(arguments, options)) return 0;
    process::start_logging("marco-slam", arguments.log_level);
    process::catch_stop_signals();
    std::optional<slam::CheckpointLock> lock;
    if (!options.checkpoint_path.empty()) lock.emplace(options.checkpoint_path);
    process::LcmBus bus(arguments.lcm_url);
    bus.keep_going_without_network();
    ForeignBus sensors(bus, process::load_options<ForeignTable>(foreign_table),
                       [](const std::string& line) { spdlog::info(line); });
    slam::SlamAdapter slam(sensors, options, [](const std::string& line) { spdlog::warn(line); });
    require_alone(arguments.lcm_url);
    slam.close_loops_in_background();
    diagnosis::LiveLoop loop(
        bus,
        {"marco-slam",
         arguments.lcm_url,
         {diagnosis::expect_scans(channels::kLidarPattern, "LIDAR or LIDAR_RAW"),
          diagnosis::expect(diagnosis::Awaited::odometry)},
         &slam.drops()},
        {[&slam] { return slam.state_line(); },
         [&] { return slam::publish_reply(bus, "marco-slam", slam.take_reply()); }},
        slam.resumed() ? ", resumed from " + options.checkpoint_path : "");
    loop.run_until_stopped();
    slam.finish();
    slam.end_checkpoint();
    loop.say_replies();
    spdlog::info("{}; loops applied late: {}", slam.drops().summary(), slam.late_loop_work());
    return 0;
  });
}
