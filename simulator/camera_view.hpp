#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/pose3.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/ray_caster.hpp"

namespace marco::sim {

/// An ideal pinhole camera: square pixels, the optical axis (x ahead) in the picture's centre.
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

/// The colour of a surface in full light: red, green, blue from 0 to 255. What is seen of glass and
/// mirrors is another surface's.
Eigen::Vector3f colour_of(const Eigen::Vector3f& normal, Material material);

/// Renders a picture with one ray a pixel. The colour of a surface follows from its material and
/// its normal, the light comes from above and from the camera; glass tints, mirrors reflect.
/// @returns rows from the top, three bytes (red, green, blue) a pixel.
std::vector<uint8_t> picture_of(const RayCaster& rays,
                                const Pose3& world_from_camera,
                                const CameraView& view);

}  // namespace marco::sim
