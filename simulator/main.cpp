#include <cstdio>

#include "drivers/camera/message.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/progress.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/convert.hpp"
#include "simulator/batch_simulation.hpp"
#include "simulator/device_lasers.hpp"
#include "simulator/live/live_cameras.hpp"

namespace marco {
namespace {

struct Arguments {
  std::string world;
  std::string tour;
  std::string preset = "default";
  std::string laser;
  std::string config;
  std::string out;
  std::string cameras;
  double pictures_every_s = 4.0;
  uint64_t seed = 1;
};

sim::SimulationOptions options_of(const Arguments& arguments) {
  sim::SimulationOptions options;
  if (arguments.preset == "harsh") options = sim::harsh_options();
  if (arguments.preset == "rover_5hz") options = sim::rover_options(5.0, 208);
  if (arguments.preset == "rover_7hz") options = sim::rover_options(7.0, 360);
  if (!arguments.laser.empty()) options.laser = sim::device_laser(arguments.laser);
  if (!arguments.config.empty()) {
    process::read_options(arguments.config, options);
  }
  return options;
}

// The pictures that the cameras of a robot file take during the tour.
class Cameras {
 public:
  Cameras(const sim::RayCaster& rays, const Arguments& arguments)
      : cameras_(rays, spec_of(arguments)) {}

  void look(const Sample& sample, Utime sent, files::EventLogWriter& log) {
    if (const auto* state = std::get_if<PanTiltState>(&sample)) cameras_.on_pantilt(*state);
    const auto* pose = std::get_if<TruePose>(&sample);
    if (pose == nullptr) return;
    if (sent >= next_info_) {
      next_info_ = sent + Duration::from_seconds(1.0);
      for (std::size_t i = 0; i < cameras_.specs().size(); ++i) {
        SensorInfo info = cameras_.info(i);
        info.utime = sent;
        const EncodedMessage message = encode_sample(info);
        log.write(message.channel, message.bytes, sent);
      }
    }
    for (const sim::LiveCameras::Shot& shot : cameras_.on_pose(*pose)) {
      const sim::LiveCameraSpec& camera = cameras_.specs()[shot.camera];
      const auto picture = drivers::camera::compress_rgb(
          shot.rgb, camera.view.width_px, camera.view.height_px, camera.jpeg_quality);
      log.write(camera.channel, encode_message(drivers::camera::to_message(picture, shot.utime)),
                sent);
    }
  }

 private:
  static sim::RobotSpec spec_of(const Arguments& arguments) {
    auto spec = process::load_options<sim::RobotSpec>(arguments.cameras);
    for (sim::LiveCameraSpec& camera : spec.cameras) {
      camera.rate_hz = 1.0 / arguments.pictures_every_s;
    }
    return spec;
  }

  sim::LiveCameras cameras_;
  Utime next_info_;
};

int run(const Arguments& arguments) {
  const sim::World world = sim::build_world(process::load_options<sim::WorldSpec>(arguments.world));
  const sim::RayCaster rays(world);
  sim::BatchSimulation simulation(rays, process::load_options<sim::Tour>(arguments.tour),
                                  options_of(arguments), arguments.seed);
  process::catch_interrupts(arguments.out + " is unchanged");
  files::OutputFile file(arguments.out);
  files::EventLogWriter log(file);
  std::optional<Cameras> cameras;
  if (!arguments.cameras.empty()) cameras.emplace(rays, arguments);
  process::Progress progress("simulating");
  simulation.run(
      [&](const Sample& sample, Utime sent) {
        const EncodedMessage message = encode_sample(sample);
        log.write(message.channel, message.bytes, sent);
        if (cameras) cameras->look(sample, sent, log);
      },
      [&progress](double part) {
        process::end_if_interrupted();
        progress.update(part);
      });
  file.finish();
  std::printf("%.0f s simulated, %lld messages in %s\n", simulation.duration_s(),
              static_cast<long long>(log.events_written()), arguments.out.c_str());
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-simulate", [&] {
    marco::process::CommandLine app(
        "Drives a simulated robot through a world and writes an LCM log of its sensors");
    marco::Arguments arguments;
    marco::process::ConfigArguments config;
    app.add_option("--world", arguments.world, "e.g. config/worlds/lab.toml").existing_file();
    app.add_option("--tour", arguments.tour, "e.g. config/tours/lab.toml").existing_file();
    app.add_option("--seed", arguments.seed).shows_default();
    app.add_option("--preset", arguments.preset,
                   "default, harsh: the noise of real logs, or rover_5hz, rover_7hz: a small "
                   "rover with a rotating lidar of 208 or 360 beams and no odometry")
        .one_of({"default", "harsh", "rover_5hz", "rover_7hz"})
        .shows_default();
    app.add_option("--laser", arguments.laser,
                   "the device whose beams are simulated; without it the preset's SICK")
        .one_of({"sick", "hokuyo", "rplidar", "ld19", "ydlidar_x4", "tim561", "leuze"});
    app.add_option("--config", arguments.config, "TOML over the preset; unknown keys are refused")
        .existing_file();
    app.add_option("--cameras", arguments.cameras,
                   "a robot, e.g. config/robots/michoacan.toml, whose cameras take pictures")
        .existing_file();
    app.add_option("--pictures-every", arguments.pictures_every_s, "seconds, of each camera")
        .between(0.02, 100.0)
        .shows_default();
    app.add_option("--out", arguments.out, "the log to write");
    marco::process::add_print_config(app, config);
    if (const auto code = app.parse(argc, argv)) return *code;
    if (marco::process::prints_config(config, marco::options_of(arguments))) return 0;
    marco::process::require_usage(
        !arguments.world.empty() && !arguments.tour.empty() && !arguments.out.empty(),
        "give --world, --tour and --out");
    return marco::run(arguments);
  });
}
