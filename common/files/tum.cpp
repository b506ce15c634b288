#include "common/files/tum.hpp"

#include <cmath>
#include <string>

#include "common/files/text_fields.hpp"
#include "common/pose3.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {

void write_tum(const std::filesystem::path& path, const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose2& stamped : trajectory) {
    const Pose2& pose = stamped.world_from_robot;
    const int64_t us = stamped.utime.us;
    text += format("%s%lld.%06lld %.6f %.6f 0 0 0 %.9f %.9f\n", us < 0 ? "-" : "",
                   static_cast<long long>(std::llabs(us) / 1000000),
                   static_cast<long long>(std::llabs(us) % 1000000), pose.x_m, pose.y_m,
                   std::sin(0.5 * pose.theta_rad), std::cos(0.5 * pose.theta_rad));
  }
  write_whole_file(path, text);
}

Trajectory read_tum(const std::filesystem::path& path) {
  Trajectory trajectory;
  for (const auto& [place, row] : read_numeric_rows(path)) {
    require(row.size() == 4 || row.size() >= 8,
            place + ": expected 'time x y z qx qy qz qw' or 'time x y theta'");
    Pose2 pose{row[1], row[2], row[3]};
    if (row.size() >= 8) pose.theta_rad = yaw_of_quaternion(row[7], row[4], row[5], row[6]);
    trajectory.push_back({Utime::from_seconds(row[0]), pose});
  }
  return trajectory;
}

}  // namespace marco::files
