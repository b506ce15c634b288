#include "common/files/tum.hpp"

#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {

void write_tum(const std::filesystem::path& path, const Trajectory& trajectory) {
  std::string text;
  char line[160];
  for (const StampedPose2& stamped : trajectory) {
    const Pose2& pose = stamped.world_from_robot;
    const int64_t us = stamped.utime.us;
    std::snprintf(line, sizeof line, "%s%lld.%06lld %.6f %.6f 0 0 0 %.9f %.9f\n", us < 0 ? "-" : "",
                  static_cast<long long>(std::llabs(us) / 1000000),
                  static_cast<long long>(std::llabs(us) % 1000000), pose.x_m, pose.y_m,
                  std::sin(0.5 * pose.theta_rad), std::cos(0.5 * pose.theta_rad));
    text += line;
  }
  write_whole_file(path, text);
}

Trajectory read_tum(const std::filesystem::path& path) {
  std::istringstream file(read_whole_file(path));
  Trajectory trajectory;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::string place = path.string() + ":" + std::to_string(number);
    const std::vector<double> row = finite_numbers(line, place);
    if (row.empty()) continue;
    require(row.size() == 4 || row.size() >= 8,
            place + ": expected 'time x y z qx qy qz qw' or 'time x y theta'");
    Pose2 pose{row[1], row[2], row[3]};
    if (row.size() >= 8) {
      pose.theta_rad = std::atan2(2.0 * (row[7] * row[6] + row[4] * row[5]),
                                  1.0 - 2.0 * (row[5] * row[5] + row[6] * row[6]));
    }
    trajectory.push_back({Utime::from_seconds(row[0]), pose});
  }
  return trajectory;
}

}  // namespace marco::files
