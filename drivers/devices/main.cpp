#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <iostream>
#include <optional>

#include "drivers/devices/robot_files.hpp"
#include "drivers/devices/survey.hpp"
#include "drivers/transport/port_advice.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/options.hpp"
#include "lcm_tools/process/arguments.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using drivers::devices::Port;
using drivers::devices::PortReport;

constexpr Limits kHeights{0.01, 5.0};  // [m]

struct Arguments {
  std::vector<std::string> ports;
  std::string write_to;
  double laser_height_m = 0.0;  ///< 0 = not given
  bool listen_only = false;
  bool udev = false;
};

std::string root() {
  const char* folder = std::getenv("MARCO_ROOT");
  require(folder != nullptr, "MARCO_ROOT is not set: start it as `marco devices`");
  return folder;
}

void print_file(const std::string& path) {
  std::ifstream file(path);
  require(file.good(), path + " cannot be read");
  for (std::string line; std::getline(file, line);) std::puts(line.c_str());
}

std::vector<Port> wanted_ports(const Arguments& arguments) {
  if (arguments.ports.empty()) return drivers::devices::ports_here();
  std::vector<Port> ports;
  ports.reserve(arguments.ports.size());
  for (const std::string& path : arguments.ports) {
    ports.push_back({path, drivers::devices::identify_port(path), true});
  }
  return ports;
}

/// All at once: a silent port takes ten seconds.
std::vector<PortReport> survey_all(const std::vector<Port>& ports, bool listen_only) {
  std::vector<std::future<PortReport>> running;
  running.reserve(ports.size());
  for (const Port& port : ports) {
    running.push_back(std::async(std::launch::async, [port, listen_only] {
      return drivers::devices::survey(port, listen_only);
    }));
  }
  std::vector<PortReport> reports;
  for (auto& one : running) {
    reports.push_back(one.get());
    const std::string identity = describe(reports.back().port.identity);
    std::printf("%s\n", describe(reports.back()).c_str());
    if (!identity.empty()) std::printf("    %s\n", identity.c_str());
    std::fflush(stdout);
  }
  return reports;
}

void list_others(drivers::DeviceKind kind, const char* what) {
  for (const drivers::DeviceSeen& seen : drivers::devices_seen(kind)) {
    const std::string by_id = seen.by_id.empty() ? "" : " (" + seen.by_id + ")";
    std::printf("%s: %s%s\n", seen.path.c_str(), what, by_id.c_str());
  }
}

/// As given; asked for on a terminal; nothing: nobody said.
std::optional<double> laser_height_m(const std::string& laser, double given_m) {
  if (given_m > 0.0) return given_m;
  if (isatty(STDIN_FILENO) == 0 || isatty(STDOUT_FILENO) == 0) return std::nullopt;
  for (std::string line = "?"; !line.empty();) {
    std::printf("Height of the plane of %s above the floor, in metres? (Enter: not measured yet) ",
                laser.c_str());
    std::fflush(stdout);
    if (!std::getline(std::cin, line) || line.empty()) break;
    char* end = nullptr;
    const double height_m = std::strtod(line.c_str(), &end);
    if (*end == '\0' && kHeights.min <= height_m && height_m <= kHeights.max) return height_m;
    std::puts("a number of metres, such as 0.18");
  }
  return std::nullopt;
}

void write_files(const std::vector<PortReport>& reports, const Arguments& arguments) {
  const std::filesystem::path there =
      std::filesystem::absolute(arguments.write_to).lexically_normal();
  std::vector<std::string> without_height;
  const auto height_m = [&](const std::string& laser) {
    const auto height = laser_height_m(laser, arguments.laser_height_m);
    if (!height) without_height.push_back(laser);
    return height;
  };
  const auto files = drivers::devices::robot_files(reports, there.string(),
                                                   root() + "/config/mapping.procman", height_m);
  require(!files.empty(), "no supported device was found: nothing to write");
  for (const auto& [name, text] : files) {
    require(!std::filesystem::exists(there / name),
            (there / name).string() + " already exists: not overwritten");
  }
  std::filesystem::create_directories(there);
  for (const auto& [name, text] : files) {
    std::ofstream file(there / name);
    require((file << text << std::flush).good(), (there / name).string() + " cannot be written");
  }
  for (const PortReport& report : reports) {
    if (report.finding.claim.kind != drivers::devices::Kind::textbase) continue;
    std::printf("\n%s/base.toml: count and measure its three numbers first", there.c_str());
  }
  for (const std::string& laser : without_height) {
    std::printf(
        "\n%s/%s.toml: measure the laser's height; until then the base drives at most "
        "0.2 m/s",
        there.c_str(), laser.c_str());
  }
  std::printf("\nwritten to %s; start it with\n    marco run %s/robot.procman go\n", there.c_str(),
              there.c_str());
}

int run(const Arguments& arguments) {
  if (arguments.udev) {
    print_file(root() + "/config/60-marco.rules");
    return 0;
  }
  const std::vector<Port> ports = wanted_ports(arguments);
  if (ports.empty()) {
    std::puts(
        "no serial ports are plugged in: `dmesg` shows what the kernel saw. Name a port of the "
        "board itself, or a laser on Ethernet, to probe it: marco devices /dev/ttyS0 "
        "tcp:192.168.0.1:2112");
  }
  const std::vector<PortReport> reports = survey_all(ports, arguments.listen_only);
  if (arguments.ports.empty()) {
    list_others(drivers::DeviceKind::gamepad, "gamepad (marco-gamepad)");
    list_others(drivers::DeviceKind::camera, "camera (marco-camera)");
  }
  if (!arguments.write_to.empty()) write_files(reports, arguments);
  // That another process holds a port is an answer.
  const bool answers = std::any_of(reports.begin(), reports.end(), [](const PortReport& one) {
    return one.trouble.empty() || one.trouble.starts_with("held by ");
  });
  return arguments.ports.empty() || answers ? process::kExitDone : process::kExitFailed;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-devices", [&] {
    process::CommandLine app(
        "Lists what is plugged in: devices on serial ports with their rates, gamepads, "
        "cameras.\nListens first, then sends queries that change nothing, but never to a port that "
        "another process holds, or that may be a modem, a satellite receiver or a terminal. Runs "
        "each laser it finds for some scans. Takes 10 s, at most half a minute");
    Arguments arguments;
    app.add_option(
        "PORT", arguments.ports,
        "probe only these, and send queries whatever they are: a path, or tcp:HOST:PORT");
    app.add_flag("--listen", arguments.listen_only, "only listen; send nothing");
    app.add_option("--write", arguments.write_to,
                   "folder for a configuration of each device, and a procman script");
    app.add_option("--laser-height", arguments.laser_height_m,
                   "for --write: height of the laser's plane above the floor [m]; without it asked "
                   "for on a terminal")
        .check([](const std::string& given) {
          const double height_m = std::strtod(given.c_str(), nullptr);
          const bool may = kHeights.min <= height_m && height_m <= kHeights.max;
          return may ? "" : "a height is 0.01 to 5 m";
        });
    app.add_flag("--udev", arguments.udev,
                 "print udev rules that give every local user access to the devices");
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(arguments);
  });
}
