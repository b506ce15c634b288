#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/pose3.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/ray_caster.hpp"

namespace marco::sim {

/// A camera without a lens's faults: pixels are square, the optical axis (x ahead) meets the
/// picture's centre.
struct CameraView {
  int width_px = 240;
  int height_px = 180;
  double field_of_view_deg = 60.0;  ///< across the width

  template <class Visitor>
  void visit(Visitor& v) {
    v("width_px", width_px, Limits{16, 4096});
    v("height_px", height_px, Limits{16, 4096});
    v("field_of_view_deg", field_of_view_deg, Limits{5.0, 150.0});
  }
  double focal_length_px() const;
};

/// What it sees: one ray a pixel, each surface in the colour of its material and the way it faces,
/// lit from above and from the camera; through glass with a tint, in mirrors what they show.
/// @returns rows from the top, three bytes (red, green, blue) a pixel.
std::vector<uint8_t> picture_of(const RayCaster& rays,
                                const Pose3& world_from_camera,
                                const CameraView& view);

}  // namespace marco::sim
