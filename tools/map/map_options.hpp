#pragma once

#include <string>

#include "mapping3d/process/mapping3d_adapter.hpp"
#include "slam/process/line_process_options.hpp"
#include "slam/process/slam_adapter.hpp"
#include "tools/map/joined_surface.hpp"
#include "tools/map/photographs.hpp"

namespace marco {

struct MapOptions {
  /// A recording ends: its keyframes are kept for the joint refinement at the end, but four of a
  /// place are enough of a long one (ten rounds of the office cost 57 s in place of 97, and hold a
  /// third; the path is as good).
  MapOptions() {
    slam.slam.culling.after_keyframes = 2000;
    slam.slam.culling.keyframes_per_place = 4;
  }

  slam::SlamAdapterOptions slam;  ///< its input, keyframes and grid hold for the others, too
  slam::LineProcessOptions lines;
  mapping3d::Mapping3dAdapterOptions mapping3d;
  mapping3d::SurfacePipelineOptions joined_surface;
  PhotographOptions photographs;
  std::string odometry_fault;  ///< why no odometry is used, no setting; "" = it is used

  template <class Visitor>
  void visit(Visitor& v) {
    v("input", slam.input);
    v("slam", slam.slam);
    v("localizer", slam.localizer);
    v("lines", lines.mapper);
    v("model", mapping3d.mapper);
    v("surface", joined_surface);
    v("photographs", photographs);
  }
};

}  // namespace marco
