#pragma once

#include <filesystem>
#include <optional>

#include "lcm_tools/log/select.hpp"
#include "recordings/sample_reader.hpp"

namespace marco::logs {

struct CarmenResult {
  int64_t scans = 0;
  int64_t odometry = 0;
  int64_t true_poses = 0;
  int64_t resampled = 0;         ///< scans put on regular bearings (make_regular)
  int64_t without_odometry = 0;  ///< scans that got the last known robot pose, or the origin
  int64_t of_more_lasers = 0;    ///< scans of a third laser: CARMEN knows two
};

/// Writes samples as a CARMEN log: ODOM lines, and each scan as FLASER (RLASER for a second laser)
/// where its beams lie as that line implies and it sits at the turning centre, else as ROBOTLASER1
/// (ROBOTLASER2), which say how. Robot poses are the odometry at the scan's stamp. Numbers are
/// written so that they read back as the same floats.
/// @param truth when given, TRUE_POSE goes there as `time x y z qx qy qz qw`.
/// @throws std::runtime_error as OutputFile.
CarmenResult export_carmen(files::SampleReader& recording,
                           OutputFile& out,
                           OutputFile* truth,
                           const OnProgress& on_progress);

}  // namespace marco::logs
