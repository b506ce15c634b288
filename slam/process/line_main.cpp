#include <spdlog/spdlog.h>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "live/calibration_file.hpp"
#include "live/diagnosis/live_loop.hpp"
#include "live/foreign_bus.hpp"
#include "slam/process/line_slam_adapter.hpp"

namespace {

int run(int argc, char** argv) {
  marco::process::CommandLine app{
      "Line SLAM: pose and walls from a laser, with odometry or without."};
  marco::process::CommonArguments arguments;
  marco::process::add_common_arguments(app, arguments);
  std::string calibration;
  marco::add_calibration_argument(app, calibration);
  std::string foreign_table;
  marco::add_foreign_argument(app, foreign_table);
  if (const auto code = app.parse(argc, argv)) return *code;
  auto options =
      marco::process::load_options<marco::slam::LineProcessOptions>(arguments.config_path);
  options.input.calibration = marco::load_calibration(calibration);
  if (marco::process::prints_config(arguments, options)) return 0;
  marco::process::start_logging("marco-line-slam", arguments.log_level);
  marco::process::catch_stop_signals();
  marco::process::LcmBus bus(arguments.lcm_url);
  bus.keep_going_without_network();
  marco::ForeignBus sensors(bus, marco::process::load_options<marco::ForeignTable>(foreign_table),
                            [](const std::string& line) { spdlog::info(line); });
  marco::slam::LineSlamAdapter adapter(options, sensors,
                                       [](const std::string& line) { spdlog::warn(line); });
  adapter.save_in_background();
  marco::diagnosis::LiveLoop loop(
      bus,
      {"marco-line-slam",
       arguments.lcm_url,
       {marco::diagnosis::expect_scans(marco::channels::kLidarPattern, "LIDAR or LIDAR_RAW"),
        marco::diagnosis::expect(marco::diagnosis::Awaited::odometry)},
       &adapter.drops()},
      {[&adapter] { return adapter.state_line(); },
       [&] { return marco::slam::publish_reply(bus, "marco-line-slam", adapter.take_reply()); }},
      adapter.resumed() ? ", resumed from " + options.checkpoint_path : "");
  loop.run_until_stopped();
  adapter.finish();
  loop.say_replies();
  spdlog::info("{} scans used; {}", adapter.scans_used(), adapter.drops().summary());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return marco::process::run_main("marco-line-slam", [&] { return run(argc, argv); });
}
