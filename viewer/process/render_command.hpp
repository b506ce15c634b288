#pragma once

#include <functional>
#include <limits>
#include <string>

#include "viewer/model_picture.hpp"
#include "viewer/renderer.hpp"

namespace marco::viewer {

/// What a person asked `marco render` for.
struct RenderRequest {
  PictureSize size;
  std::string camera;  ///< "" = what suits; above, eye, front, robot, or x,y,z,yaw,pitch
  Projection projection = Projection::perspective;
  Look look;
  double wall_height_m = 0.0;  ///< above 0: the map's walls stand so high; else kWallHeightM
  double cut_height_m = std::numeric_limits<double>::infinity();  ///< in place of the planned one
};

/// "1280x720". @throws std::invalid_argument naming the text and what was expected.
PictureSize parse_size(const std::string& text);

/// The scene as asked for: a scene with only a map and paths becomes a 2D map unless a camera or
/// wall height was asked for; all else a picture in space.
/// @throws std::invalid_argument when there is nothing to draw or the camera is not understood.
Picture render_scene(Scene scene, const RenderRequest& request);

/// What a picture in space shows of a scene: beside a model the map is left out unless a wall
/// height was asked for; a map alone stands up, with the driven path on its floor.
Scene scene_in_space(Scene scene, const RenderRequest& request);

/// The view a request means for a scene in space, before it is drawn. The renderer, with the scene
/// loaded, finds the heading of "eye".
ViewPlan plan_request(const Scene& scene, const RenderRequest& request, Renderer& renderer);

/// Above, front, eye, and above by normals, two by two.
Picture render_sheet(const Scene& scene, RenderRequest request);

/// Writes an MP4: the drive along the path through model or map, or, without one, once round the
/// scene.
/// @returns the number of pictures. @throws as FilmWriter and render_scene.
int render_film(Scene scene, const RenderRequest& request, const std::string& path);

/// Walks by keys (Walk::press) from the same start: `next_key` waits for the next and gives 0 at
/// the end, `show` gets what the robot sees, at first and after each key that moved it; drawn with
/// level of detail. @returns the number of pictures.
int render_walk_by_keys(Scene scene,
                        const RenderRequest& request,
                        const std::function<char()>& next_key,
                        const std::function<void(const Picture&)>& show);

/// Walks by a script (walk.hpp) from the start of the scene's path, or from its middle, and writes
/// what the robot sees at first and after each command: 000.png, 001.png ... into a folder.
/// @returns the number of pictures.
int render_walk(Scene scene,
                const RenderRequest& request,
                const std::string& script,
                const std::string& folder);

}  // namespace marco::viewer
