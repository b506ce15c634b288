#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/emergency_stop.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "live/diagnosis/silence_watch.hpp"
#include "marco/slam_pose_t.hpp"
#include "teleop/operator.hpp"
#include "teleop/screen.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using teleop::Operator;
using teleop::RobotView;

void listen(process::LcmBus& bus, process::DropCounter& drops, RobotView& view, Operator& hands) {
  bus.subscribe<base_status_t>(
      channels::kBaseStatus, drops,
      [&view](const auto& message, const auto&) { view.base = from_message(message); });
  bus.subscribe<odometry_t>(channels::kOdometry, drops, [&view](const auto& message, const auto&) {
    view.odometry = from_message(message);
  });
  bus.subscribe<pantilt_state_t>(channels::kPanTiltState, drops,
                                 [&view, &hands](const auto& message, const auto&) {
                                   view.head = from_message(message);
                                   hands.on_pantilt(*view.head);
                                 });
  bus.subscribe<slam_pose_t>(channels::kSlamPose, drops,
                             [&view](const slam_pose_t& message, const auto&) {
                               const Pose2 pose{message.x_m, message.y_m, message.theta_rad};
                               if (is_finite(pose)) view.world_from_robot = pose;
                             });
  bus.subscribe<grid_map_t>(channels::kGridMap, drops,
                            [&view](const grid_map_t& message, const auto&) {
                              view.add_tile(from_message(message), message.revision);
                            });
  bus.subscribe<gamepad_t>(channels::kGamepad, drops, [&hands](const auto& message, const auto&) {
    hands.on_gamepad(from_message(message), drivers::wall_now());
  });
  bus.subscribe<emergency_stop_t>(
      channels::kEmergencyStop, drops, [&hands](const auto& message, const auto&) {
        const EmergencyStop stop = from_message(message);
        hands.on_emergency_stop({stop.utime.us, stop.engaged, stop.sender, stop.reason});
      });
}

void show(const RobotView& view) {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) size = {24, 80, 0, 0};
  const std::string screen = teleop::draw_screen(view, size.ws_col, size.ws_row);
  std::string out = "\x1b[H";  // home; each line is cleared to its end, so that nothing flickers
  for (const char c : printable(screen, Newline::kept)) {
    if (c == '\n') out += "\x1b[K\r";
    out += c;
  }
  out += "\x1b[K\x1b[J";
  std::fwrite(out.data(), 1, out.size(), stdout);
  std::fflush(stdout);
}

void send(process::LcmBus& bus, const Operator::Orders& orders) {
  for (const BaseCommand& command : orders.base) {
    bus.publish(channels::kBaseCommand, to_message(command));
  }
  for (const PanTiltCommand& command : orders.pantilt) {
    bus.publish(channels::kPanTiltCommand, to_message(command));
  }
  for (const auto& stop : orders.emergency) process::publish(bus, stop);
}

enum class Hands { keys_and_gamepad, gamepad };

int run(const process::CommonArguments& arguments, Hands driven_by) {
  const auto options = process::load_options<teleop::OperatorOptions>(arguments.config_path);
  if (process::prints_config(arguments, options)) return 0;
  require(driven_by == Hands::gamepad || isatty(STDIN_FILENO) == 1,
          "standard input is not a terminal, so keys cannot be read: start it in its own terminal, "
          "or with --no-keys for a gamepad alone");
  process::start_logging("marco-teleop", arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  process::DropCounter drops;
  Operator hands(options);
  RobotView view;
  listen(bus, drops, view, hands);
  teleop::Keyboard keyboard;
  diagnosis::SilenceWatch silence(
      bus,
      {"marco-teleop", arguments.lcm_url, {diagnosis::expect(diagnosis::Awaited::base)}, nullptr});
  const bool screen = isatty(STDOUT_FILENO) == 1;
  if (screen) std::fputs("\x1b[2J\x1b[?25l", stdout);
  Utime next_screen;
  try {
    while (!process::stop_requested() && !hands.wants_to_quit()) {
      bus.handle_once(20);
      const Utime now = drivers::wall_now();
      while (const auto key = keyboard.key()) {
        if (driven_by == Hands::keys_and_gamepad) hands.on_key(*key, now);
      }
      send(bus, hands.step(now));
      if (const auto note = silence.step()) {
        view.notice = note->trouble ? note->text : "";
        if (!screen) diagnosis::log_note(note);
      }
      if (!screen || now < next_screen) continue;
      next_screen = now + Duration::from_us(200'000);
      view.speed_factor = hands.speed_factor();
      view.gamepad_trouble = hands.gamepad_trouble();
      show(view);
    }
  } catch (...) {
    send(bus, hands.stop(drivers::wall_now()));
    throw;
  }
  send(bus, hands.stop(drivers::wall_now()));
  if (screen) std::fputs("\x1b[?25h\n", stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-teleop", [&] {
    process::CommandLine app(
        "Drives the robot by keyboard and gamepad and shows pose, map, battery, bumpers, speed.\n"
        "Arrows drive while held, i k j l move by steps, t g f h turn the pan-tilt, r looks "
        "ahead,\n"
        "+ and - change the speed, space stops, e is the emergency stop and c clears it, q ends");
    process::CommonArguments arguments;
    process::add_common_arguments(app, arguments);
    bool no_keys = false;
    app.add_flag("--no-keys", no_keys, "drive with the gamepad alone; needs no terminal");
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(arguments, no_keys ? Hands::gamepad : Hands::keys_and_gamepad);
  });
}
