#include <sys/stat.h>

#include <cstdio>
#include <filesystem>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/sim_fault_t.hpp"
#include "simulator/devices/transport/emulator_port.hpp"
#include "simulator/live/live_robot.hpp"
#include "simulator/tour.hpp"
#include "simulator/world.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

struct Arguments {
  process::CommonArguments common;  ///< its config is the robot
  std::string world;
  std::string tour;
  std::vector<double> start{0.0, 0.0, 0.0};
  std::string ports = "ports";
  uint64_t seed = 1;
  std::string fault_script;
};

Pose2 start_of(const Arguments& arguments) {
  if (arguments.tour.empty()) {
    return {arguments.start[0], arguments.start[1], deg_to_rad(arguments.start[2])};
  }
  const auto tour = process::load_options<sim::Tour>(arguments.tour);
  require(tour.start_m.size() == 2, "start_m: expected two numbers, x and y");
  return {tour.start_m[0], tour.start_m[1], deg_to_rad(tour.start_heading_deg)};
}

std::vector<drivers::EmulatorPort> open_ports(const sim::LiveRobot& robot,
                                              const sim::RobotSpec& spec,
                                              const std::string& folder) {
  std::filesystem::create_directories(folder);
  std::vector<drivers::EmulatorPort> ports;
  for (const sim::LiveRobot::Device& device : robot.devices()) {
    ports.push_back(device.tcp_port >= 0
                        ? drivers::EmulatorPort::tcp(*device.emulator, device.tcp_port)
                        : drivers::EmulatorPort::pty(*device.emulator, folder + "/" + device.port));
    std::printf("%-10s %s\n", device.port.c_str(), ports.back().address().c_str());
  }
  if (spec.gamepad) {
    // Joystick records written into it act as a gamepad.
    const std::string fifo = folder + "/gamepad";
    require(mkfifo(fifo.c_str(), 0666) == 0 || std::filesystem::is_fifo(fifo),
            fifo + ": could not be made a FIFO");
    std::printf("%-10s %s\n", "gamepad", fifo.c_str());
  }
  std::fflush(stdout);
  return ports;
}

/// Plugs and unplugs devices according to the fault `unplugged`.
void move_plugs(const sim::LiveRobot& robot,
                const sim::FaultBoard& faults,
                std::vector<drivers::EmulatorPort>& ports,
                std::vector<bool>& plugged,
                Utime now) {
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const bool wanted = !faults.has(robot.devices()[i].port, sim::FaultKind::unplugged, now);
    if (wanted == plugged[i]) continue;
    if (wanted) ports[i].plug_in();
    if (!wanted) ports[i].unplug();
    plugged[i] = wanted;
  }
}

std::string state_of(const sim::LiveRobot& robot, const sim::FaultBoard& faults, Utime now) {
  const std::string broken = faults.state(now);
  if (!broken.empty()) return "faults: " + broken;
  return robot.contact().any() ? "the robot touches something" : "running";
}

int run(const Arguments& arguments) {
  const auto spec = process::load_options<sim::RobotSpec>(arguments.common.config_path);
  if (process::prints_config(arguments.common, spec)) return 0;
  process::start_logging("marco-sim", arguments.common.log_level);
  process::catch_stop_signals();
  const sim::World world = sim::build_world(process::load_options<sim::WorldSpec>(arguments.world));
  const sim::RayCaster rays(world);
  sim::LiveRobot robot(rays, spec, start_of(arguments), arguments.seed);
  std::vector<drivers::EmulatorPort> ports = open_ports(robot, spec, arguments.ports);
  std::vector<drivers::EmulatorPort*> served;
  served.reserve(ports.size());
  for (drivers::EmulatorPort& port : ports) served.push_back(&port);
  process::LcmBus bus(arguments.common.lcm_url);
  process::DropCounter drops;
  process::StatusPublisher status(bus, "marco-sim", drops);
  const Duration longest = Duration::from_us(2000), pose_period = Duration::from_us(20000);
  if (!arguments.fault_script.empty()) {
    const auto script = process::load_options<sim::FaultScript>(arguments.fault_script);
    for (const sim::FaultSpec& fault : script.faults) {
      robot.faults().add(fault, drivers::wall_now());
    }
  }
  bus.subscribe<sim_fault_t>(channels::kSimFault, drops, [&robot](const auto& order, const auto&) {
    robot.faults().add({order.device, order.kind, order.start_s, order.duration_s},
                       drivers::wall_now());
  });
  std::vector<bool> plugged(ports.size(), true);
  Utime next_pose;
  while (!process::stop_requested()) {
    drivers::serve_ports(served, longest);
    while (bus.handle_once(0)) {
    }
    const Utime now = drivers::wall_now();
    robot.update(now);
    move_plugs(robot, robot.faults(), ports, plugged, now);
    if (now < next_pose) continue;
    next_pose = now + pose_period;
    bus.publish(channels::kTruePose, to_message(TruePose{now, robot.world_from_robot()}));
    status.tick(state_of(robot, robot.faults(), now));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-sim", [&] {
    process::CommandLine app("A simulated robot in real time; each device has its own port");
    Arguments arguments;
    process::add_common_arguments(app, arguments.common);
    app.option("--config").described("the robot, e.g. config/robots/michoacan.toml");
    app.add_option("--world", arguments.world, "e.g. config/worlds/lab.toml")
        .required()
        .existing_file();
    app.add_option("--tour", arguments.tour, "start where this tour starts").existing_file();
    app.add_option("--start", arguments.start, "X Y DEGREES, without a tour").values(3);
    app.add_option("--ports", arguments.ports, "folder for the links to the ports").shows_default();
    app.add_option("--seed", arguments.seed).shows_default();
    app.add_option("--fault-script", arguments.fault_script,
                   "[[faults]] device, kind, start_s, duration_s; also accepted on SIM_FAULT")
        .existing_file();
    app.add_flag_that_ends(
        "--faults", [] { std::fputs(sim::describe_faults().c_str(), stdout); },
        "list the faults that a device can have");
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(arguments);
  });
}
