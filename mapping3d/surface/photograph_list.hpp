#pragma once

#include <string>
#include <vector>

#include "mapping3d/surface/simplify.hpp"
#include "mapping3d/surface/texture.hpp"

namespace marco {

/// A photograph for `marco texture`, with the pose of its camera.
struct PhotographSpec {
  std::string file;                                    ///< in the list's folder or below
  std::vector<double> position_m = {0, 0, 0};          ///< of the camera, in the model's frame
  std::vector<double> quaternion_xyzw = {0, 0, 0, 1};  ///< model from camera: z ahead, y down
  std::vector<double> focal_px = {0};                  ///< one, or x and y
  std::vector<double> centre_px;                       ///< default: the middle of the picture
  double k1 = 0.0;
  double k2 = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("file", file);
    v("position_m", position_m);
    v("quaternion_xyzw", quaternion_xyzw);
    v("focal_px", focal_px, kPositive);
    v("centre_px", centre_px);
    v("k1", k1);
    v("k2", k2);
  }
};

/// Read by `marco texture`; `marco map` writes it for a recording with pictures.
struct PhotographList {
  std::vector<PhotographSpec> photographs;
  mapping3d::TextureOptions texture;
  mapping3d::SimplifyOptions simplify;

  template <class Visitor>
  void visit(Visitor& v) {
    v("photographs", photographs);
    v("texture", texture);
    v("simplify", simplify);
  }
};

}  // namespace marco
