#include "drivers/devices/robot_files.hpp"

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::devices {
namespace {

/// A device of the robot to be.
struct Part {
  std::string name;  ///< "laser", "laser_2"
  const PortReport* report = nullptr;
  std::string publishes;  ///< the channel to wait for; "" = none
};

std::string role_of(Kind kind) {
  if (is_laser(kind)) return "laser";
  if (kind == Kind::imu || kind == Kind::bno055) return "imu";
  return kind == Kind::hcs12_pantilt ? "pantilt" : "base";
}

std::string quoted(const std::string& path) {
  require(path.find_first_of("\"'\\\n") == std::string::npos,
          path + ": a procman script cannot contain a path with quotes or backslashes");
  return "\"" + path + "\"";
}

std::vector<Part> parts_of(const std::vector<PortReport>& reports) {
  std::map<std::string, int> count, all;
  for (const PortReport& report : reports) {
    if (is_device(report.finding.claim.kind)) ++all[role_of(report.finding.claim.kind)];
  }
  std::vector<Part> parts;
  for (const PortReport& report : reports) {
    const Kind kind = report.finding.claim.kind;
    if (!is_device(kind)) continue;
    const std::string role = role_of(kind);
    const std::string number = std::to_string(++count[role]);
    Part part{role, &report, ""};
    if (number != "1") part.name.append("_").append(number);
    if (role == "laser") part.publishes = all[role] == 1 ? "LIDAR" : "LIDAR_" + number;
    if (role == "base") part.publishes = "ODOMETRY";
    parts.push_back(std::move(part));
  }
  return parts;
}

bool has_no_rate(const Port& port) {
  return port.path.starts_with("tcp:") || port.identity.usb_id.starts_with("15d1:") ||
         port.path.find("ttyACM") != std::string::npos;
}

std::string settings_of(const Part& part) {
  const Kind kind = part.report->finding.claim.kind;
  const std::string baud = "baud = " + std::to_string(part.report->finding.baud) + "\n";
  switch (kind) {
    case Kind::hokuyo:
      return "[hokuyo]\nbaud = " + std::string(has_no_rate(part.report->port) ? "0" : "115200") +
             "  # 0 = USB or Ethernet, which have none\n";
    case Kind::leuze:
      return "[leuze]\n" + baud;
    case Kind::imu:
      return "[imu]\n" + baud;
    case Kind::create:
      return "[base]\n" + baud;
    case Kind::textbase:
      return "# Count and measure these three; the base does not start without them.\n"
             "# [base]\n# ticks_per_turn = 1440        # of a wheel\n"
             "# wheel_diameter_m = 0.065\n# track_m = 0.16               # from wheel to wheel\n";
    default:
      return "";
  }
}

/// Nobody but a person knows it, and a wrong one blinds the base's obstacle guard.
std::string place_of(const Part& part, const LaserHeight& height_m) {
  const auto height = height_m(part.name);
  const std::string line = height ? format("position_m = [0.0, 0.0, %g]\n", *height)
                                  : "# position_m = [0.0, 0.0, HEIGHT]  # until it is given, the "
                                    "base drives at most 0.2 m/s\n";
  return "[place]\nchannel = " + quoted(part.publishes) +
         "\n# Measure its position: x ahead, y left, z up, from the floor below the middle "
         "between "
         "the driven wheels.\n# `marco calibrate` finds x, y and the last angle from a recorded "
         "drive, and not the height.\n" +
         line + "roll_pitch_yaw_deg = [0.0, 0.0, 0.0]\n";
}

std::string config_of(const Part& part, const LaserHeight& height_m) {
  const PortReport& report = *part.report;
  std::string text = "# " + program_of(report.finding.claim.kind) + ": " +
                     report.finding.claim.name +
                     (report.finding.baud > 0 ? " at " + std::to_string(report.finding.baud) : "") +
                     ", found by `marco devices`\ndevice = " + quoted(report.port.path) + "\n";
  if (is_laser(report.finding.claim.kind)) text += place_of(part, height_m);
  return text + settings_of(part);
}

std::string command_of(const Part& part, const std::string& folder) {
  const std::string file = folder + "/" + part.name + ".toml";
  quoted(file);
  return "  cmd \"" + part.name + "\" {\n    exec = \"" +
         program_of(part.report->finding.claim.kind) + " --config '" + file +
         "'\";\n    deputy = \"localhost\";\n    auto_respawn = \"true\";\n"
         "    stop_time_allowed = 3;\n  }\n";
}

std::string start_of(const Part& part) {
  const std::string start = "  start cmd \"" + part.name + "\"";
  if (part.publishes.empty()) return start + ";\n";
  return start + " wait publishing \"" + part.publishes + "\" timeout ms 30000 then abort;\n";
}

}  // namespace

std::map<std::string, std::string> robot_files(const std::vector<PortReport>& reports,
                                               const std::string& folder,
                                               const std::string& mapping,
                                               const LaserHeight& height_m) {
  std::map<std::string, std::string> files;
  std::string commands, starts;
  for (const Part& part : parts_of(reports)) {
    files[part.name + ".toml"] = config_of(part, height_m);
    commands += command_of(part, folder);
    starts += start_of(part);
  }
  if (files.empty()) return files;
  files["robot.procman"] =
      "# The devices that `marco devices` found; each has its settings next to this file:\n"
      "#   marco run " +
      folder + "/robot.procman go\n\ninclude " + quoted(mapping) + ";\n\ngroup \"robot\" {\n" +
      commands +
      "}\n\nscript \"go\" {\n  start cmd \"page\";\n  start cmd \"slam\" wait \"running\";\n"
      "  start cmd \"logger\" wait \"running\";\n" +
      starts +
      "}\n\nscript \"halt\" {\n  stop group \"robot\" wait \"stopped\";\n"
      "  stop cmd \"logger\" wait \"stopped\";\n  stop group \"mapping\" wait \"stopped\";\n"
      "  stop cmd \"page\" wait \"stopped\";\n}\n";
  return files;
}

}  // namespace marco::drivers::devices
