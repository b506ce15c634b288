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

void Check::judge_motion(const SeenMotion& seen, double ahead, double left) {
  const double way_m = seen.start_from_end.x_m, turn_rad = seen.start_from_end.theta_rad;
  figures = {
      {"moved_m", way_m}, {"turned_deg", rad_to_deg(turn_rad)}, {"stands_after_s", seen.stands_s}};
  if (seen.begins_s) figures.emplace_back("order_to_motion_s", *seen.begins_s);
  const bool as_ordered = left == 0.0 ? ahead * way_m > 0.01 && std::abs(turn_rad) < 0.2
                                      : left * turn_rad > 0.04 && std::abs(way_m) < 0.05;
  if (!as_ordered) fault = "odometry shows another motion";
  if (seen.stands_s > 1.0) fault = "it did not stop within a second";
}

void Check::judge_hand(const std::optional<NearestReturn>& nearest, double bearing_deg) {
  fault = "no laser sees anything";
  if (!nearest) return;
  const double left_deg = rad_to_deg(nearest->bearing_rad);
  figures = {{"nearest_m", nearest->range_m}, {"left_deg", left_deg}};
  fault = std::abs(left_deg - bearing_deg) > 25.0 ? "the hand is seen elsewhere" : "";
}

void Check::judge_push(const Pose2& way) {
  figures = {{"moved_m", way.x_m}, {"left_m", way.y_m}, {"turned_deg", rad_to_deg(way.theta_rad)}};
  if (std::abs(way.x_m - 1.0) > 0.1) fault = "odometry differs from 1 m ahead";
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
