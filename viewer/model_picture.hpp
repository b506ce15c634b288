#pragma once

#include <array>

#include "viewer/model_survey.hpp"
#include "viewer/renderer.hpp"

namespace marco::viewer {

/// above: obliquely from above, without the ceiling. front: from a side, like a doll's house. eye:
/// from the middle of the driven path, or of the model, towards the best view. For maps see
/// plan_map_view().
enum class View { above, front, eye };

struct ViewPlan {
  Camera camera;
  Look look;
};

/// Chooses camera, cut and back faces so that rooms are recognizable. A scene with neither meshes
/// nor a map is always seen from above.
/// @param look its mode, colouring, light and quality are kept.
/// @throws std::invalid_argument when the scene is empty.
ViewPlan plan_view(
    const Scene& scene, View view, const Look& look, Projection projection, PictureSize size);

/// The path the robot drove: the one called "estimate", else the one with the most poses; nullptr
/// when the scene has no path with a pose.
const PathItem* driven_path(const Scene& scene);

/// The heading with the best view from `eye_m`, tried in steps of 22.5 deg on small pictures.
/// @param renderer has the scene loaded.
double best_heading_rad(Renderer& renderer, const Eigen::Vector3d& eye_m);

/// Draws a scale bar with its label along the box's floor edge nearest to the eye, unless it would
/// leave the picture.
Picture add_scale_bar(const Picture& picture, const Camera& camera, const Box& box);

/// Draws a bar of the height colours into the lower right corner, with the height above the lowest.
/// @param range_m lowest and highest, of height_range_m()
Picture add_height_legend(const Picture& picture, const std::array<double, 2>& range_m);

}  // namespace marco::viewer
