#pragma once

#include <vector>

#include "mapping3d/registration.hpp"
#include "mapping3d/surface_pipeline.hpp"
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

}  // namespace marco
