#include <spdlog/spdlog.h>

#include "common/files/ply.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "live/calibration_file.hpp"
#include "live/diagnosis/live_loop.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

namespace {

struct ProcessOptions : mapping3d::Mapping3dAdapterOptions {
  template <class Visitor>
  void visit(Visitor& v) {
    Mapping3dAdapterOptions::visit(v);
    v("surface", mapper.surface);
  }
};

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-mapping3d", [&] {
    process::CommandLine app("3D models: LIDAR on a pan-tilt and SLAM_POSE in, SCENE and MESH out");
    process::CommonArguments arguments;
    std::string out;
    std::string calibration_path;
    process::add_common_arguments(app, arguments);
    app.add_option("--out", out, "PLY file for the final model");
    add_calibration_argument(app, calibration_path);
    if (const auto code = app.parse(argc, argv)) return *code;
    auto options = process::load_options<ProcessOptions>(arguments.config_path);
    const CalibrationFile calibration = load_calibration(calibration_path);
    options.input.calibration = calibration;
    options.input.pantilt_late_s = calibration.pantilt.late_s;
    options.correction = calibration.pantilt;
    if (process::prints_config(arguments, options)) return 0;
    process::start_logging("marco-mapping3d", arguments.log_level);
    process::catch_stop_signals();
    process::LcmBus bus(arguments.lcm_url);
    bus.keep_going_without_network();
    mapping3d::Mapping3dAdapter adapter(bus, options,
                                        [](const std::string& line) { spdlog::warn(line); });
    diagnosis::LiveLoop loop(
        bus,
        {"marco-mapping3d",
         arguments.lcm_url,
         {diagnosis::expect_scans(channels::kLidarPattern, "LIDAR or LIDAR_RAW"),
          diagnosis::expect(diagnosis::Awaited::laser_on_pantilt),
          diagnosis::expect(diagnosis::Awaited::slam_poses),
          diagnosis::expect(diagnosis::Awaited::pantilt)},
         &adapter.drops()},
        {[&adapter] { return std::to_string(adapter.mapper().scenes().size()) + " scenes"; }});
    process::StatusPublisher before_work(bus, "marco-mapping3d", adapter.drops());
    adapter.announce_long_work([&](const std::string& state) { before_work.send(state); });
    loop.run_until_stopped();
    adapter.finish();
    if (!out.empty()) files::write_ply(out, adapter.mapper().model());
    spdlog::info("{}", adapter.drops().summary());
    return 0;
  });
}
