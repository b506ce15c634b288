#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/files/points/point_files.hpp"
#include "mapping3d/registration.hpp"
#include "mapping3d/surface_pipeline.hpp"
#include "tools/map/stage_clock.hpp"
#include "tools/model/cloud_scan.hpp"

namespace marco {

struct CloudModelOptions {
  mapping3d::RegistrationOptions registration;
  mapping3d::SurfacePipelineOptions joined_surface;
  bool refine = true;

  /// Poses of scanners are known less well than those of a robot on its floor.
  CloudModelOptions() {
    registration.path_sigma_m = 0.3;
    registration.path_sigma_deg = 3.0;
    registration.floor_sigma_m = 0.1;
    registration.floor_sigma_deg = 1.0;
  }

  template <class Visitor>
  void visit(Visitor& v) {
    v("refine", refine, "Align the scans in 3D. Off to keep their given poses.");
    v("registration", registration);
    v("joined_surface", joined_surface);
  }
};

/// One surface from scans whose poses are known roughly.
struct CloudModel {
  mapping3d::RegistrationResult registration;
  TriangleMesh mesh;  ///< world frame; coloured where the scans are, or have intensities
  mapping3d::JoinedSurface joined;
};

/// Registers the scans, whose poses it corrects, and fuses them.
CloudModel make_cloud_model(std::vector<CloudScan>& scans, const CloudModelOptions& options);

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
