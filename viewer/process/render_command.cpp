#include "viewer/process/render_command.hpp"

#include <cmath>
#include <cstdio>

#include "common/check.hpp"
#include "viewer/map_picture.hpp"

namespace marco::viewer {
namespace {

ViewPlan plan_named_view(const Scene& scene, View view, const RenderRequest& request) {
  return plan_view(scene, view, request.look, request.projection, request.size);
}

ViewPlan plan_requested_view(const Scene& scene, const RenderRequest& request) {
  if (request.camera.empty() || request.camera == "above")
    return plan_named_view(scene, View::above, request);
  if (request.camera == "front") return plan_named_view(scene, View::front, request);
  if (request.camera == "eye") return plan_named_view(scene, View::eye, request);
  ViewPlan plan{parse_camera(request.camera), request.look};
  plan.camera.projection = request.projection;
  return plan;
}

}  // namespace

PictureSize parse_size(const std::string& text) {
  PictureSize size;
  char rest = '\0';
  require(std::sscanf(text.c_str(), "%dx%d%c", &size.width_px, &size.height_px, &rest) == 2 &&
              size.width_px > 0 && size.height_px > 0,
          "size \"" + text + "\": expected WIDTHxHEIGHT in pixels, for example 1280x720");
  return size;
}

Picture render_scene(Scene scene, const RenderRequest& request) {
  scene.grid_wall_height_m = request.wall_height_m;
  const bool flat = scene.meshes.empty() && request.camera.empty() && request.wall_height_m <= 0.0;
  if (flat) {
    MapPictureOptions options;
    options.long_side_px = std::max(request.size.width_px, request.size.height_px);
    return draw_map(scene, options).picture;
  }
  // The model has its own floor; a grid would only flicker through it.
  if (!scene.meshes.empty() && request.wall_height_m <= 0.0) scene.grid.reset();
  require(!bounding_box(scene).empty(), "nothing to draw: no triangle, known cell or pose");
  Renderer renderer;
  renderer.load(scene);
  ViewPlan plan = plan_requested_view(scene, request);
  if (std::isfinite(request.cut_height_m)) plan.look.cut_height_m = request.cut_height_m;
  if (request.camera == "eye") {
    const double heading_rad = best_heading_rad(renderer, plan.camera.eye_m);
    plan.camera.target_m =
        plan.camera.eye_m + Eigen::Vector3d(std::cos(heading_rad), std::sin(heading_rad), 0.0);
  }
  const Picture picture = renderer.draw(plan.camera, plan.look, request.size);
  const bool outside =
      request.camera.empty() || request.camera == "above" || request.camera == "front";
  if (!outside) return picture;
  const Box box = scene.meshes.empty() ? bounding_box(scene) : survey_model(scene).box;
  return add_scale_bar(picture, plan.camera, box);
}

}  // namespace marco::viewer
