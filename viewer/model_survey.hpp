#pragma once

#include <optional>

#include "viewer/scene.hpp"

namespace marco::viewer {

/// The rooms of a model, estimated from its triangles.
struct ModelSurvey {
  Box box;  ///< of the largest connected part, less 0.5 % on each side
  double floor_m = 0.0;
  std::optional<double> ceiling_m;  ///< the highest large level surface well above the floor
  bool visible_from_inside =
      false;  ///< the floor's triangles face up: back faces are the outsides of walls
};

/// @throws std::invalid_argument when the scene's meshes hold no triangle with an area.
ModelSurvey survey_model(const Scene& scene);

/// Wall area that turns its front to a far viewer in direction `towards_eye`, foreshortened.
/// @param towards_eye unit length.
double facing_wall_area_m2(const Scene& scene, const Eigen::Vector3d& towards_eye);

}  // namespace marco::viewer
