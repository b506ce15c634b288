#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/trajectory.hpp"
#include "landmarks/bearing_convention.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco {

/// A car whose file has a steering angle instead of a turn rate.
struct CarOptions {
  double wheelbase_m = 0.0;
  double speed_wheel_left_m = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("wheelbase_m", wheelbase_m, kNotNegative,
      "From the rear axle to the front one. Needed if drive.csv has a steering angle.");
    v("speed_wheel_left_m", speed_wheel_left_m,
      "The wheel whose speed is recorded, to the left of the rear axle's middle. 0 = the middle.");
  }
};

struct PostsInput {
  slam::LandmarkDrive drive;  ///< bearings as the file counts them
  Trajectory truth;           ///< positions, headings 0; empty = not known
  std::string truth_file;
  bool truth_is_gps = false;
};

/// Reads drive, scans, the sightings (sightings, posts or trees) and truth or gps from a folder,
/// .csv or .csv.gz; docs/posts.md lists the columns.
/// @throws std::invalid_argument naming file and fault
PostsInput read_posts_folder(const std::filesystem::path& folder, const CarOptions& car);

}  // namespace marco
