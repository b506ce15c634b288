#pragma once

#include <functional>
#include <limits>
#include <string>

#include "viewer/model_picture.hpp"
#include "viewer/renderer.hpp"

namespace marco::viewer {

/// The options of `marco render`.
struct RenderRequest {
  PictureSize size;
  std::string camera;  ///< "" = automatic; above, eye, front, robot, or x,y,z,yaw,pitch
  Projection projection = Projection::perspective;
  Look look;
  double wall_height_m = 0.0;  ///< of a map's walls; 0: kWallHeightM
  double cut_height_m = std::numeric_limits<double>::infinity();  ///< instead of the planned one
};

/// "1280x720". @throws std::invalid_argument naming the text and what was expected.
PictureSize parse_size(const std::string& text);

/// Draws a scene: only a map and paths as a 2D map, unless a camera or wall height is given; all
/// else in 3D.
/// @throws std::invalid_argument when there is nothing to draw or the camera cannot be parsed.
Picture render_scene(Scene scene, const RenderRequest& request);

/// The scene of a 3D picture: a map given with a model is left out unless a wall height is given; a
/// map alone gets upright walls, with the driven path on its floor.
Scene scene_in_space(Scene scene, const RenderRequest& request);

/// The view of a 3D scene. The renderer, with the scene loaded, finds the heading of "eye".
ViewPlan plan_request(const Scene& scene, const RenderRequest& request, Renderer& renderer);

/// Above, front, eye, and above by normals, two by two.
Picture render_sheet(const Scene& scene, RenderRequest request);

/// Writes an MP4: a drive along the path through model or map, or an orbit of the scene without a
/// path.
/// @returns the number of pictures. @throws as FilmWriter and render_scene.
int render_film(Scene scene, const RenderRequest& request, const std::string& path);

/// Walks by keys (Walk::press) from the same start. `next_key` waits for a key and returns 0 at the
/// end; `show` gets the robot's view at the start and after each key that moved it, drawn with
/// level of detail. @returns the number of pictures.
int render_walk_by_keys(Scene scene,
                        const RenderRequest& request,
                        const std::function<char()>& next_key,
                        const std::function<void(const Picture&)>& show);

/// Walks by a script (walk.hpp) from the start of the scene's path, or from the middle of the
/// scene. Writes the robot's view at the start and after each command to a folder: 000.png, 001.png
/// ...
/// @returns the number of pictures.
int render_walk(Scene scene,
                const RenderRequest& request,
                const std::string& script,
                const std::string& folder);

}  // namespace marco::viewer
