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
  std::vector<uint8_t> rgb;  ///< the atlas, row by row from the top; grey between the charts
  double painted = 0.0;      ///< part of the texels that a picture sees; others are filled in
  int pictures_used = 0;
  int pictures_refused = 0;  ///< wrong number of pixels, no focal length or no finite pose
  std::vector<Eigen::Vector3f>
      gains;  ///< of the used pictures: red, green, blue; picture_gains.hpp
};

/// Texture mapping from photographs. Charts are connected triangles with one main axis, projected
/// along it. Pictures are made equally bright first (picture_gains.hpp). A texel takes the colour
/// of the best view by merit (texture_view.hpp), with seams of some centimetres, times a gain that
/// is smooth along the surface and makes all views equal in the low frequencies (local_gains.hpp).
/// Where three or more pictures see a texel, those that contradict the majority do not count
/// (surface_looks.hpp). A texel that no picture sees gets a colour that spreads from the surface
/// around it. Memory besides the pictures: 5 bytes a pixel of theirs, 4 a texel (268 MB for an
/// atlas of 8192 x 8192), and at most 300 MB for the surface's points (surface_looks.hpp).
/// @param mesh  best simplified before
/// @throws std::invalid_argument where the charts do not fit into an atlas of max_atlas_px
TexturedSurface paint(const TriangleMesh& mesh,
                      const std::vector<CameraPicture>& pictures,
                      const TextureOptions& options = {});

}  // namespace marco::mapping3d
