#pragma once

#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/process/emergency_stop.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "live/sensor_feed.hpp"
#include "teleop/terminal.hpp"

namespace marco::teleop {

/// A robot on the network, and the person at the terminal who looks after it. Not thread-safe.
class AttendedRobot {
 public:
  explicit AttendedRobot(process::LcmBus& bus) : bus_(bus) {
    bus.subscribe<base_status_t>(channels::kBaseStatus, drops_,
                                 [this](const auto& message, const auto&) {
                                   base = from_message(message);
                                   base_heard_ = drivers::wall_now();
                                   if (base->command == BaseStatus::Command::refused)
                                     refused = base->note;
                                 });
    bus.subscribe<odometry_t>(
        channels::kOdometry, drops_,
        [this](const auto& message, const auto&) { track.push_back(from_message(message)); });
    feed(bus, drops_, sensors_, {{}, [this] {
                                   while (auto scan = sensors_.next())
                                     scans[scan->info.channel] = std::move(*scan);
                                 }});
  }

  std::optional<BaseStatus> base;
  std::string refused;  ///< why an order was
  std::vector<OdometrySample> track;
  std::map<std::string, SynchronizedScan> scans;  ///< the newest of each laser

  /// The track begins with where the robot is now.
  void begin_track() {
    await_odometry();
    if (!track.empty()) track.erase(track.begin(), track.end() - 1);
  }
  /// Waits until odometry shows where the robot is now.
  void await_odometry() {
    constexpr double kLateS = 1.5;
    const Utime now = drivers::wall_now();
    wait(kLateS, [&] { return !track.empty() && track.back().utime >= now; });
  }
  bool is_latched() const { return base->note.starts_with(kEmergencyStopNote); }

  /// Handles messages for so long. @throws std::runtime_error after a signal, and when the base
  /// falls silent.
  void listen(double seconds) {
    constexpr double kSilentS = 2.0;  // a base reports twice a second
    const Utime end = drivers::wall_now() + Duration::from_seconds(seconds);
    do {
      const bool all_handled = !bus_.handle_once(10);  // this process may have stood still itself
      if (process::stop_requested()) throw std::runtime_error("stopped by a signal");
      if (all_handled && base && (drivers::wall_now() - base_heard_).seconds() > kSilentS) {
        throw std::runtime_error("the base no longer answers");
      }
    } while (drivers::wall_now() < end);
  }
  bool wait(double seconds, const std::function<bool()>& done) {
    const Utime end = drivers::wall_now() + Duration::from_seconds(seconds);
    while (!done() && drivers::wall_now() < end) listen(0.01);
    return done();
  }

  std::optional<char> key() { return keyboard_.key(); }
  /// One of `keys`, pressed after the question: one that is still held does not count.
  /// @param idle  is called while nothing is pressed; true ends the wait, and 0 is returned
  char ask(
      const std::string& question, const std::string& keys, const std::function<bool()>& idle = [] {
        return false;
      }) {
    for (bool held = true; held;) {
      listen(0.2);
      held = key().has_value();
      while (key()) {
      }
    }
    print(stdout, "%s", question.c_str());
    while (true) {
      std::fflush(stdout);
      listen(0.05);
      const char pressed = key().value_or('\0');
      const bool counts = pressed != '\0' && keys.find(pressed) != std::string::npos;
      if (counts) print(stdout, " %c\n", pressed);
      if (counts || idle()) return counts ? pressed : '\0';
    }
  }

  void send(BaseCommand command) {
    command.utime = drivers::wall_now();
    command.id = command.utime.us;
    bus_.publish(channels::kBaseCommand, to_message(command));
  }
  void emergency_stop(process::EmergencyStop what) {
    process::send_emergency_stop(bus_, what, "marco first-drive", "its test");
  }

 private:
  process::LcmBus& bus_;
  process::DropCounter drops_;
  SensorSynchronizer sensors_{{}, lcm_channel_names(), {}};
  Keyboard keyboard_;
  Utime base_heard_;
};

}  // namespace marco::teleop
