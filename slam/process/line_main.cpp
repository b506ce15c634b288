#include <spdlog/spdlog.h>

#include "common/diagnosis/process/silence_watch.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "slam/process/line_lcm_adapter.hpp"

namespace {

int run(int argc, char** argv) {
  CLI::App app{"Line SLAM: pose and walls from a laser and odometry."};
  marco::process::CommonArguments arguments;
  marco::process::add_common_arguments(app, arguments);
  if (const auto code = marco::process::parse_arguments(app, argc, argv)) return *code;
  const auto options =
      marco::process::load_options<marco::slam::LineProcessOptions>(arguments.config_path);
  if (arguments.print_config) {
    std::fputs(marco::process::print_options(options).c_str(), stdout);
    return 0;
  }
  marco::process::start_logging("marco-line-slam", arguments.log_level);
  marco::process::catch_stop_signals();
  marco::process::LcmBus bus(arguments.lcm_url);
  marco::slam::LineLcmAdapter adapter(options, bus,
                                      [](const std::string& line) { spdlog::warn(line); });
  adapter.keep_to_one_laser();
  adapter.save_in_background();
  marco::process::StatusPublisher status(bus, "marco-line-slam", adapter.drops());
  auto scans = marco::diagnosis::expect_scans(options.lidar_channel, options.lidar_channel);
  scans.types = {options.lidar_channel == marco::channels::kLidarRaw ? "marco.lidar_raw_t"
                                                                     : "bot_core.planar_lidar_t"};
  scans.elsewhere = "set lidar_channel in the config (LIDAR_RAW for lidar_raw_t)";
  marco::diagnosis::SilenceWatch silence(
      bus, {"marco-line-slam",
            arguments.lcm_url,
            {scans, marco::diagnosis::expect(marco::diagnosis::Awaited::odometry)},
            &adapter.drops()});
  spdlog::info("listening on {}{}", marco::process::effective_lcm_url(arguments.lcm_url),
               adapter.resumed() ? ", goes on from " + options.checkpoint_path : "");
  const auto answer = [&] {
    for (std::string said = adapter.take_answer(); !said.empty(); said = adapter.take_answer()) {
      spdlog::info("{}", said);
      status.send(said);
    }
  };
  while (!marco::process::stop_requested()) {
    bus.handle_once(100);
    marco::diagnosis::log_note(silence.step());
    status.tick(silence.state(std::to_string(adapter.live_trajectory().size()) + " scans, " +
                              std::to_string(adapter.mapper().filter().num_walls()) + " walls"));
    answer();
  }
  adapter.finish();
  answer();
  spdlog::info("{} scans used, {} of them without odometry; {}", adapter.scans_used(),
               adapter.scans_guessed(), adapter.drops().summary());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return marco::process::run_main("marco-line-slam", [&] { return run(argc, argv); });
}
