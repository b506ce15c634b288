#pragma once

#include <limits>
#include <string>

#include "viewer/model_picture.hpp"

namespace marco::viewer {

/// What a person asked `marco render` for.
struct RenderRequest {
  PictureSize size;
  std::string camera;  ///< "" = what suits; above, eye, front, or x,y,z,yaw,pitch
  Projection projection = Projection::perspective;
  Look look;
  double wall_height_m = 0.0;  ///< above 0: the map's walls stand up in 3D
  double cut_height_m = std::numeric_limits<double>::infinity();  ///< in place of the planned one
};

/// "1280x720". @throws std::invalid_argument naming the text and what was expected.
PictureSize parse_size(const std::string& text);

/// The scene as asked for: a scene with only a map and paths becomes a 2D map unless a camera or
/// wall height was asked for; all else a picture in space.
/// @throws std::invalid_argument when there is nothing to draw or the camera is not understood.
Picture render_scene(Scene scene, const RenderRequest& request);

}  // namespace marco::viewer
