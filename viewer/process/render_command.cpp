#include "viewer/process/render_command.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "viewer/film.hpp"
#include "viewer/image_io.hpp"
#include "viewer/map_picture.hpp"
#include "viewer/map_view.hpp"
#include "viewer/standing_map.hpp"
#include "viewer/walk.hpp"

namespace marco::viewer {
namespace {

ViewPlan plan_named_view(const Scene& scene, View view, const RenderRequest& request) {
  return plan_view(scene, view, request.look, request.projection, request.size);
}

double floor_of(const Scene& scene) {
  return scene.meshes.empty() ? 0.0 : survey_model(scene).floor_m;
}

// At the newest pose of the driven path.
Camera robot_camera(const Scene& scene) {
  const PathItem* path = driven_path(scene);
  require(path != nullptr,
          "--camera robot: there is no trajectory, so the pose of the robot is unknown");
  return Walk(path->poses.back().world_from_robot, floor_of(scene)).camera();
}

Look look_of(const Scene& scene, const RenderRequest& request) {
  return scene.meshes.empty() && scene.grid ? map_look(request.look, scene.grid_wall_height_m)
                                            : request.look;
}

ViewPlan plan_by_name(const Scene& scene, const RenderRequest& request) {
  if (request.camera.empty() || request.camera == "above")
    return plan_named_view(scene, View::above, request);
  if (request.camera == "front") return plan_named_view(scene, View::front, request);
  if (request.camera == "eye") return plan_named_view(scene, View::eye, request);
  ViewPlan plan{request.camera == "robot" ? robot_camera(scene) : parse_camera(request.camera),
                look_of(scene, request)};
  plan.camera.projection = request.projection;
  return plan;
}

Box box_to_frame(const Scene& scene) {
  if (!scene.meshes.empty()) return survey_model(scene).box;
  return scene.grid ? map_box(*scene.grid, scene.grid_wall_height_m) : bounding_box(scene);
}

// An orbit around the box.
std::vector<Camera> orbit_cameras(const Scene& scene, const RenderRequest& request) {
  constexpr int kPictures = 180;
  const Box box = box_to_frame(scene);
  Camera camera;
  camera.projection = request.projection;
  camera.field_of_view_rad = deg_to_rad(35.0);
  // One distance for all views, so that the size of the model does not change.
  Box round = box;
  const double reach_m = 0.5 * box.size_m().head<2>().norm();
  round.min_m.head<2>() = box.center_m().head<2>() - Eigen::Vector2d::Constant(0.8 * reach_m);
  round.max_m.head<2>() = box.center_m().head<2>() + Eigen::Vector2d::Constant(0.8 * reach_m);
  std::vector<Camera> cameras;
  const Camera first = fit_camera(camera, round, 0.0, deg_to_rad(48.0), request.size.aspect());
  for (int i = 0; i < kPictures; ++i) {
    const double turn_rad = 2.0 * std::numbers::pi * i / kPictures;
    const Eigen::AngleAxisd turn(turn_rad, Eigen::Vector3d::UnitZ());
    Camera turned = first;
    turned.eye_m = box.center_m() + turn * (first.eye_m - box.center_m());
    turned.target_m = box.center_m() + turn * (first.target_m - box.center_m());
    cameras.push_back(turned);
  }
  return cameras;
}

// Loose lines have no rooms to drive through.
bool can_drive(const Scene& scene) {
  return driven_path(scene) != nullptr && (!scene.meshes.empty() || scene.grid);
}

std::vector<Camera> film_cameras(const Scene& scene, const RenderRequest& request) {
  constexpr double kStepM = 0.05;
  constexpr double kEyeHeightM = 1.0;
  if (!can_drive(scene)) return orbit_cameras(scene, request);
  return drive_cameras(driven_path(scene)->poses, kStepM, floor_of(scene) + kEyeHeightM);
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

Scene scene_in_space(Scene scene, const RenderRequest& request) {
  scene.grid_wall_height_m = request.wall_height_m > 0.0 ? request.wall_height_m : kWallHeightM;
  // The model has its own floor and walls; a map would flicker through them.
  if (!scene.meshes.empty() && request.wall_height_m <= 0.0) scene.grid.reset();
  // Odometry leaves the building, and the truth hides the path.
  if (scene.grid && scene.meshes.empty())
    std::erase_if(scene.paths, [](const PathItem& path) {
      return path.label == "odometry" || path.label == "truth";
    });
  return scene;
}

namespace {

// From inside a map its path would look like a pipe.
void load_from_inside(Renderer& renderer, const Scene& scene) {
  if (!scene.meshes.empty() || !scene.grid) return renderer.load(scene);
  Scene rooms = scene;
  rooms.paths.clear();
  renderer.load(rooms);
}

bool stands_inside(const RenderRequest& request) {
  return request.camera == "eye" || request.camera == "robot";
}

}  // namespace

Picture render_scene(Scene scene, const RenderRequest& request) {
  const bool flat = scene.meshes.empty() && request.camera.empty() && request.wall_height_m <= 0.0;
  if (flat) {
    MapPictureOptions options;
    options.long_side_px = std::max(request.size.width_px, request.size.height_px);
    return draw_map(scene, options).picture;
  }
  scene = scene_in_space(std::move(scene), request);
  require(!bounding_box(scene).empty(), "nothing to draw: no triangle, known cell or pose");
  Renderer renderer;
  stands_inside(request) ? load_from_inside(renderer, scene) : renderer.load(scene);
  const ViewPlan plan = plan_request(scene, request, renderer);
  Picture picture = renderer.draw(plan.camera, plan.look, request.size);
  const bool outside =
      request.camera.empty() || request.camera == "above" || request.camera == "front";
  if (!outside) return picture;
  picture = add_scale_bar(picture, plan.camera, box_to_frame(scene));
  if (scene.meshes.empty() || plan.look.coloring != Coloring::height) return picture;
  return add_height_legend(picture, height_range_m(plan.look, bounding_box(scene)));
}

ViewPlan plan_request(const Scene& scene, const RenderRequest& request, Renderer& renderer) {
  ViewPlan plan = plan_by_name(scene, request);
  if (std::isfinite(request.cut_height_m)) plan.look.cut_height_m = request.cut_height_m;
  if (request.camera == "eye" && !scene.meshes.empty()) {
    const double heading_rad = best_heading_rad(renderer, plan.camera.eye_m);
    plan.camera.target_m =
        plan.camera.eye_m + Eigen::Vector3d(std::cos(heading_rad), std::sin(heading_rad), 0.0);
  }
  return plan;
}

Picture render_sheet(const Scene& scene, RenderRequest request) {
  std::vector<Picture> pictures;
  for (const char* camera : {"above", "front", "eye"}) {
    request.camera = camera;
    pictures.push_back(render_scene(scene, request));
  }
  request.camera = "above";
  request.look.coloring = Coloring::normal;
  pictures.push_back(render_scene(scene, request));
  return contact_sheet(pictures, 2);
}

int render_film(Scene scene, const RenderRequest& request, const std::string& path) {
  constexpr double kFramesPerSecond = 25.0;
  scene = scene_in_space(std::move(scene), request);
  Renderer renderer;
  load_from_inside(renderer, scene);
  const Look look = can_drive(scene) ? look_of(scene, request)
                                     : plan_named_view(scene, View::above, request).look;
  FilmWriter film(path, request.size.width_px, request.size.height_px, kFramesPerSecond);
  for (const Camera& camera : film_cameras(scene, request))
    film.add(renderer.draw(camera, look, request.size));
  film.finish();
  return film.frame_count();
}

namespace {

struct StartedWalk {
  Look look;
  Walk robot;
};

// At the start of the driven path, or at the viewpoint of "eye".
StartedWalk start_walk(Renderer& renderer, Scene scene, const RenderRequest& request) {
  scene = scene_in_space(std::move(scene), request);
  load_from_inside(renderer, scene);
  const ViewPlan eye = plan_named_view(scene, View::eye, request);
  const PathItem* path = driven_path(scene);
  Pose2 world_from_robot{eye.camera.eye_m.x(), eye.camera.eye_m.y(), 0.0};
  if (path != nullptr) world_from_robot = path->poses.front().world_from_robot;
  return {eye.look, Walk(world_from_robot, floor_of(scene))};
}

}  // namespace

int render_walk(Scene scene,
                const RenderRequest& request,
                const std::string& script,
                const std::string& folder) {
  const std::vector<WalkCommand> commands = parse_walk(script);
  Renderer renderer;
  StartedWalk walk = start_walk(renderer, std::move(scene), request);
  files::OutputFolder pictures(folder, "walk");
  int count = 0;
  const auto look_around = [&] {
    write_png(renderer.draw(walk.robot.camera(), walk.look, request.size),
              (pictures.path() / format("%03d.png", count++)).string());
  };
  look_around();
  for (const WalkCommand& command : commands) {
    walk.robot.apply(command);
    look_around();
  }
  pictures.commit();
  return count;
}

int render_walk_by_keys(Scene scene,
                        const RenderRequest& request,
                        const std::function<char()>& next_key,
                        const std::function<void(const Picture&)>& show) {
  constexpr double kDetailPx = 1.5;
  Renderer renderer;
  StartedWalk walk = start_walk(renderer, std::move(scene), request);
  walk.look.detail_px = kDetailPx;
  int count = 1;
  show(renderer.draw(walk.robot.camera(), walk.look, request.size));
  for (char key = next_key(); key != 0; key = next_key()) {
    if (!walk.robot.press(key)) continue;
    show(renderer.draw(walk.robot.camera(), walk.look, request.size));
    ++count;
  }
  return count;
}

}  // namespace marco::viewer
