#include "tools/map/calibration.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <sstream>

#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcmtypes/channels.hpp"
#include "live/calibration_file.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"

namespace marco {
namespace {

/// Said behind a key of calibration.toml, e.g. of "laser.x_m".
using Comments = std::map<std::string, std::string>;

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

void print_table(const slam::SelfCalibration& found) {
  if (!found.parameters.empty()) {
    print(stdout, "%-24s %10s %10s %10s  %s\n", "parameter", "before", "found", "sd", "");
  }
  for (const slam::CalibratedParameter& parameter : found.parameters) {
    const bool seen = parameter.verdict != slam::ParameterVerdict::not_observed;
    print(stdout, "%-24s %10.4f %10s %10s  %s\n", parameter.name.c_str(), parameter.before,
          seen ? number(parameter.found).c_str() : "-",
          parameter.sigma > 0.0 ? number(parameter.sigma).c_str() : "-",
          slam::reason_of(parameter).c_str());
  }
  for (const std::string& remark : found.remarks) print(stdout, "note: %s\n", remark.c_str());
  if (!found.open_question.empty()) print(stdout, "open: %s\n", found.open_question.c_str());
}

Comments comments_of(const slam::SelfCalibration& found) {
  Comments comments;
  for (const slam::CalibratedParameter& parameter : found.parameters) {
    std::string& comment = comments[parameter.name];
    if (parameter.sigma > 0.0) {
      const bool applied = parameter.verdict == slam::ParameterVerdict::applied;
      if (!applied) comment += "found " + number(parameter.found) + ", ";
      comment += "sd " + number(parameter.sigma) + ", ";
    }
    comment += slam::reason_of(parameter);
  }
  return comments;
}

Comments comments_of(const mapping3d::CalibrationResult& pantilt) {
  Comments comments;
  std::istringstream found(process::print_options(pantilt.found));
  std::istringstream sigma(process::print_options(pantilt.sigma));
  for (std::string line, sd; std::getline(found, line) && std::getline(sigma, sd);) {
    const std::size_t equals = line.find(" = ");
    if (equals == std::string::npos) continue;
    comments["pantilt." + line.substr(0, equals)] =
        "found " + number(std::stod(line.substr(equals + 3))) + ", sd " +
        number(std::stod(sd.substr(equals + 3)));
  }
  return comments;
}

std::string commented(const CalibrationFile& file, const Comments& comments) {
  std::string text =
      "# For --calibration of ./marco map and marco-slam. sd: standard deviation; lengths in m.\n";
  std::istringstream lines(process::print_options(file));
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) section = line.substr(1, line.find(']') - 1) + ".";
    const auto comment = comments.find(section + line.substr(0, line.find(" = ")));
    text += line + (comment == comments.end() ? "" : "  # " + comment->second) + "\n";
  }
  return text;
}

}  // namespace

const SensorInfo* mount_of_laser(const MapJob& job) {
  const auto& sensors = job.recorded().sensors;
  const auto is_laser = [](const auto& sensor) {
    return sensor.first.starts_with(channels::kLidar);
  };
  auto laser = std::find_if(sensors.begin(), sensors.end(), [&](const auto& sensor) {
    const SensorInfo& info = sensor.second;
    return is_laser(sensor) && info.mount == SensorInfo::Mount::robot &&
           !is_steep(info.parent_from_sensor);
  });
  if (laser == sensors.end()) laser = std::find_if(sensors.begin(), sensors.end(), is_laser);
  if (laser == sensors.end()) return nullptr;
  if (laser->second.mount == SensorInfo::Mount::robot) return &laser->second;
  const auto pantilt = sensors.find(channels::kPanTiltState);
  return pantilt == sensors.end() ? nullptr : &pantilt->second;
}

namespace {

bool calibrate_pantilt(const MapJob& job, CalibrationFile& file, Comments& comments) {
  const auto found = job.mapping3d().calibrate();
  if (!found) return false;
  using Status = mapping3d::CalibrationResult::Status;
  print(
      stdout, "pan-tilt: %s, %zu patches seen twice, %.1f -> %.1f mm apart; standard deviations:\n",
      to_string(found->status).c_str(), found->pairs, 1e3 * found->before_m, 1e3 * found->after_m);
  std::fputs(process::print_options(found->sigma).c_str(), stdout);
  if (found->status == Status::nothing_seen_twice) return false;
  file.pantilt = found->correction;
  comments.merge(comments_of(*found));
  return true;
}

}  // namespace

std::optional<slam::SelfCalibration> self_calibration_of(const MapJob& job) {
  const SensorInfo* mount = mount_of_laser(job);
  if (mount == nullptr ||
      (job.recorded().odometry.empty() && job.recorded().gyro_heading.empty())) {
    return std::nullopt;
  }
  slam::CalibrationInput input;
  input.channel = mount->channel;
  input.robot_from_laser = flatten(mount->parent_from_sensor);
  input.laser_upside_down = mount->parent_from_sensor.linear()(2, 2) < 0.0;
  input.odometry = job.recorded().odometry;
  input.gyro_heading = job.recorded().gyro_heading;
  for (const StampedPose2& pose : job.trajectory()) {
    input.world_from_laser.push_back({pose.utime, pose.world_from_robot * input.robot_from_laser});
  }
  slam::SelfCalibration found = slam::self_calibrate(input);
  if (job.calibration().laser.channel == input.channel)
    found.calibration.laser.channel = input.channel;
  return found;
}

bool write_calibration(const std::filesystem::path& path, const MapJob& job) {
  CalibrationFile file;
  Comments comments;
  const auto drive = self_calibration_of(job);
  if (drive) {
    print_table(*drive);
    static_cast<SensorCalibration&>(file) = drive->calibration;
    comments = comments_of(*drive);
  }
  file.beams = job.calibration().beams;
  file.body = job.calibration().body;
  file.floor = job.calibration().floor;
  const bool has_pantilt = calibrate_pantilt(job, file, comments);
  const bool has_drive = drive && !drive->parameters.empty();
  if (!has_pantilt && !has_drive && file.body.empty() && file.beams.empty() && file.floor.empty()) {
    return false;
  }
  files::write_whole_file(path, commented(file, comments));
  return true;
}

}  // namespace marco
