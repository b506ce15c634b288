#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/files/points/point_files.hpp"
#include "tools/map/stage_clock.hpp"
#include "tools/model/cloud_model.hpp"

namespace marco {

/// poses.txt: of each scan its file's name, x y z [m] and the quaternion x y z w.
void write_poses(const std::filesystem::path& path, const std::vector<CloudScan>& scans);

/// All points of the scans in one file, world frame, with their intensities and colours where every
/// scan has them; of uos a file for each scan with its pose. The scans' files are read once more.
void write_all_points(const std::filesystem::path& folder,
                      files::PointFormat format,
                      const std::string& ending,
                      const std::vector<CloudScan>& scans);

/// report.json.
void write_model_report(const std::filesystem::path& path,
                        const CloudModel& model,
                        const std::vector<CloudScan>& scans,
                        const std::vector<std::string>& left_out,
                        const StageClock& clock);

/// The lines after the work, the last one the verdict: good, or doubtful with the reason.
void print_model_summary(const CloudModel& model,
                         const std::vector<CloudScan>& scans,
                         const std::vector<std::string>& left_out,
                         const StageClock& clock,
                         const std::string& out);

}  // namespace marco
