#pragma once

#include <array>
#include <vector>

#include "common/pose3.hpp"
#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::mapping3d {

/// A pinhole with radial distortion: x_d = x (1 + k1 r2 + k2 r4) for the ideal x = X/Z, y = Y/Z.
struct CameraModel {
  int width_px = 0;
  int height_px = 0;
  double focal_x_px = 0.0;
  double focal_y_px = 0.0;
  double centre_x_px = 0.0;  ///< of the upper left pixel's centre: 0
  double centre_y_px = 0.0;
  double k1 = 0.0;
  double k2 = 0.0;
};

/// A photograph and where it was taken. The camera looks along its own z, x to the right, y down.
struct CameraPicture {
  CameraModel camera;
  Pose3 world_from_camera = Pose3::Identity();
  std::vector<uint8_t> rgb;  ///< row by row from the top
};

struct TextureOptions {
  double texel_m = 0.02;
  int max_atlas_px = 8192;          ///< of a side; texels grow until all charts fit
  double hidden_m = 0.04;           ///< depth tolerance of the occlusion test
  double max_incidence_deg = 84.0;  ///< flatter views are not used
  double best_view_power = 4.0;     ///< exponent of the blending weights
  double border_part = 0.15;        ///< part of the picture's width over which a view fades out

  template <class Visitor>
  void visit(Visitor& v) {
    v("texel_m", texel_m, Limits{0.001, 1.0},
      "Size of a texel. Less for sharper pictures, at the cost of memory.");
    v.advanced("max_atlas_px", max_atlas_px, Limits{64, 32768},
               "Largest side of the texture atlas. Texels grow until all fit.");
  }
};

struct TexturedSurface {
  TriangleMesh mesh;                 ///< vertices doubled where charts meet
  std::vector<Eigen::Vector2f> uvs;  ///< one a vertex, (0, 0) the atlas' upper left corner
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> rgb;  ///< the atlas, row by row from the top; grey where no picture sees
  double painted = 0.0;      ///< part of the texels that a picture sees
  int pictures_used = 0;
  int pictures_refused = 0;  ///< wrong number of pixels, no focal length or no finite pose
};

/// Texture mapping from photographs. Charts are connected triangles with one main axis, projected
/// along it. Each texel blends all pictures that see it (by a depth buffer of the mesh) with
/// weights (cos^2 / distance^2, fading to the picture's edge) to the power `best_view_power`:
/// mostly the best view, with soft seams. @param mesh best simplified before
TexturedSurface paint(const TriangleMesh& mesh,
                      const std::vector<CameraPicture>& pictures,
                      const TextureOptions& options = {});

}  // namespace marco::mapping3d
