#include "viewer/walk.hpp"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "lcm_tools/base/check.hpp"

namespace marco::viewer {
namespace {

constexpr int kMostUnits = 65535;

WalkCommand parse_command(const std::string& word) {
  WalkCommand command{word.front(), 0};
  const char* begin = word.data() + 1;
  const char* end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(begin, end, command.units);
  require(std::string("aridge").find(command.letter) != std::string::npos && begin != end &&
              error == std::errc() && rest == end && command.units >= 0 &&
              command.units <= kMostUnits,
          "walk command \"" + word +
              "\": expected a, r, i, d, e or g and a whole number of units, for example a10");
  return command;
}

}  // namespace

std::vector<WalkCommand> parse_walk(const std::string& script) {
  std::vector<WalkCommand> commands;
  std::istringstream lines(script);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) commands.push_back(parse_command(word));
  }
  return commands;
}

Walk::Walk(const Pose2& world_from_robot, double floor_m, WalkOptions options)
    : options_(options), world_from_robot_(world_from_robot), floor_m_(floor_m) {
  validate(options_, "walk");
}

void Walk::apply(const WalkCommand& command) {
  const double forward_m = command.units * options_.forward_unit_m;
  const double turn_rad = deg_to_rad(command.units * options_.turn_unit_deg);
  switch (command.letter) {
    case 'a':
      world_from_robot_ = world_from_robot_ * Pose2{forward_m, 0.0, 0.0};
      break;
    case 'r':
      world_from_robot_ = world_from_robot_ * Pose2{-forward_m, 0.0, 0.0};
      break;
    case 'i':
      world_from_robot_ = world_from_robot_ * Pose2{0.0, 0.0, turn_rad};
      break;
    case 'd':
      world_from_robot_ = world_from_robot_ * Pose2{0.0, 0.0, -turn_rad};
      break;
    case 'e':
      tilt_rad_ = deg_to_rad(std::min(
          options_.tilt_min_deg + command.units * options_.tilt_unit_deg, options_.tilt_max_deg));
      break;
    case 'g':
      pan_rad_ = normalize_angle(deg_to_rad(command.units * options_.pan_unit_deg));
      break;
    default:
      require(false, std::string("no walk command: ") + command.letter);
  }
}

bool Walk::press(char key) {
  const double tilt_deg = rad_to_deg(tilt_rad_);
  switch (key) {
    case 'a':
    case 'r':
    case 'i':
    case 'd':
      apply({key, 1});
      return true;
    case 'e':
      tilt_rad_ = deg_to_rad(std::min(tilt_deg + options_.tilt_unit_deg, options_.tilt_max_deg));
      return true;
    case 'E':
      tilt_rad_ = deg_to_rad(std::max(tilt_deg - options_.tilt_unit_deg, options_.tilt_min_deg));
      return true;
    case 'g':
    case 'G':
      pan_rad_ = normalize_angle(
          pan_rad_ + deg_to_rad(key == 'g' ? options_.pan_unit_deg : -options_.pan_unit_deg));
      return true;
    default:
      return false;
  }
}

Camera Walk::camera() const {
  const Pose3 world_from_eye =
      lift(world_from_robot_) *
      make_pose3({0.0, 0.0, floor_m_ + options_.eye_height_m}, 0.0, -tilt_rad_, pan_rad_);
  return camera_at(world_from_eye);
}

}  // namespace marco::viewer
