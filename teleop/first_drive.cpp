#include "teleop/first_drive.hpp"

#include <cmath>

#include "lcm_tools/base/printable.hpp"

namespace marco::teleop {
namespace {

bool differ(const Pose2& a, const Pose2& b) {
  const Pose2 moved = between(a, b);
  return std::hypot(moved.x_m, moved.y_m) > 0.002 || std::abs(moved.theta_rad) > deg_to_rad(0.5);
}

std::string toml_line(const std::string& key, const std::string& text) {
  std::string line = key + " = \"";
  for (const char c : printable(text)) {
    if (c == '"' || c == '\\') line += '\\';
    line += c;
  }
  return line + "\"\n";
}

}  // namespace

SeenMotion seen_motion(const std::vector<OdometrySample>& track, Utime ordered, Utime stopped) {
  SeenMotion seen;
  if (track.empty()) return seen;
  Pose2 start = track.front().odom_from_robot;
  const Pose2 end = track.back().odom_from_robot;
  for (const OdometrySample& sample : track) {
    if (sample.utime <= ordered) start = sample.odom_from_robot;
    if (!seen.begins_s && differ(start, sample.odom_from_robot)) {
      seen.begins_s = (sample.utime - ordered).seconds();
    }
    if (sample.utime > stopped && differ(sample.odom_from_robot, end)) {
      seen.stands_s = (sample.utime - stopped).seconds();
    }
  }
  seen.start_from_end = between(start, end);
  return seen;
}

std::optional<NearestReturn> nearest_return(const std::map<std::string, SynchronizedScan>& newest,
                                            Utime now) {
  std::optional<NearestReturn> best;
  for (const auto& [channel, laser] : newest) {
    if ((now - laser.scan.utime).seconds() > 1.0) continue;
    for (std::size_t beam = 0; beam < laser.scan.size(); ++beam) {
      const double range_m = laser.scan.ranges_m[beam], bearing = laser.scan.bearing_rad(beam);
      const bool is_return = range_m > laser.info.range_min_m && range_m < laser.info.range_max_m;
      if (!is_return || (best && range_m >= best->range_m)) continue;
      const Eigen::Vector3d ray = laser.robot_from_sensor.linear() *
                                  Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0.0);
      best = NearestReturn{range_m, std::atan2(ray.y(), ray.x())};
    }
  }
  return best;
}

const char* Check::result() const {
  if (answer == "no" || !fault.empty()) return "WRONG";
  return answer == "yes" ? "ok" : answer.c_str();
}

bool DriveReport::is_good() const {
  return ended_early.empty() && std::none_of(checks.begin(), checks.end(), [](const Check& check) {
           return check.result() == std::string("WRONG");
         });
}

std::string DriveReport::to_text() const {
  std::string text = "first drive of " + printable(base) + ", Marco " + version + "\n";
  for (const Check& check : checks) {
    text += format("  %-14s %-7s", check.name.c_str(), check.result());
    for (const auto& [name, value] : check.figures)
      text += format("  %s %.3f", name.c_str(), value);
    text += (check.fault.empty() ? "" : "  " + printable(check.fault)) + "\n";
  }
  return ended_early.empty() ? text : text + "  ended early: " + printable(ended_early) + "\n";
}

std::string DriveReport::to_toml() const {
  std::string toml = "# " + to_text();
  for (std::size_t at = 0; (at = toml.find("\n  ", at)) != std::string::npos;)
    toml.insert(++at, "#");
  toml += toml_line("version", version) + toml_line("robot", robot) + toml_line("base", base) +
          toml_line("ended_early", ended_early);
  for (const Check& check : checks) {
    toml += "\n[[checks]]\n" + toml_line("name", check.name) + toml_line("result", check.result()) +
            toml_line("answer", check.answer) + toml_line("fault", check.fault);
    for (const auto& [name, value] : check.figures) toml += name + format(" = %.4f\n", value);
  }
  return toml;
}

}  // namespace marco::teleop
