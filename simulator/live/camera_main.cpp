#include "drivers/camera/message.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "simulator/live/live_cameras.hpp"
#include "simulator/world.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

int run(const process::CommonArguments& arguments, const std::string& world_path) {
  const auto spec = process::load_options<sim::RobotSpec>(arguments.config_path);
  if (process::prints_config(arguments, spec)) return 0;
  process::start_logging("marco-sim-camera", arguments.log_level);
  process::catch_stop_signals();
  const sim::World world = sim::build_world(process::load_options<sim::WorldSpec>(world_path));
  const sim::RayCaster rays(world);
  sim::LiveCameras cameras(rays, spec);
  process::LcmBus bus(arguments.lcm_url);
  process::DropCounter drops;
  process::StatusPublisher status(bus, "marco-sim-camera", drops);
  std::optional<TruePose> newest;  // older poses are skipped
  bus.subscribe<pose2_t>(
      channels::kTruePose, drops,
      [&](const pose2_t& message, const process::RawMessage&) { newest = from_message(message); });
  bus.subscribe<pantilt_state_t>(channels::kPanTiltState, drops,
                                 [&](const pantilt_state_t& message, const process::RawMessage&) {
                                   cameras.on_pantilt(from_message(message));
                                 });
  int64_t pictures = 0;
  Utime next_info;
  while (!process::stop_requested()) {
    bus.handle_once(50);
    while (bus.handle_once(0)) {
    }
    const Utime now = drivers::wall_now();
    if (now >= next_info) {
      next_info = now + Duration::from_seconds(1.0);
      for (std::size_t i = 0; i < cameras.specs().size(); ++i) {
        SensorInfo info = cameras.info(i);
        info.utime = now;
        bus.publish(channels::kSensorInfo, to_message(info));
      }
    }
    status.tick(std::to_string(pictures) + " pictures");
    if (!newest) continue;
    for (const sim::LiveCameras::Shot& shot : cameras.on_pose(*newest)) {
      const sim::LiveCameraSpec& camera = cameras.specs()[shot.camera];
      const auto picture = drivers::camera::compress_rgb(
          shot.rgb, camera.view.width_px, camera.view.height_px, camera.jpeg_quality);
      bus.publish(camera.channel, drivers::camera::to_message(picture, shot.utime));
      ++pictures;
    }
    newest.reset();
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-sim-camera", [&] {
    process::CommandLine app(
        "The cameras of a robot in marco-sim: pictures of the simulated world");
    process::CommonArguments arguments;
    process::add_common_arguments(app, arguments);
    app.option("--config").described("the robot, as marco-sim has it");
    std::string world;
    app.add_option("--world", world, "as marco-sim has it").required().existing_file();
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(arguments, world);
  });
}
