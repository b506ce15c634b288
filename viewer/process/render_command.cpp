#include "viewer/process/render_command.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "common/check.hpp"
#include "viewer/film.hpp"
#include "viewer/image_io.hpp"
#include "viewer/map_picture.hpp"
#include "viewer/walk.hpp"

namespace marco::viewer {
namespace {

ViewPlan plan_named_view(const Scene& scene, View view, const RenderRequest& request) {
  return plan_view(scene, view, request.look, request.projection, request.size);
}

const PathItem* longest_path(const Scene& scene) {
  const PathItem* longest = nullptr;
  for (const PathItem& path : scene.paths)
    if (longest == nullptr || path.poses.size() >= longest->poses.size()) longest = &path;
  return longest;
}

double floor_of(const Scene& scene) {
  return scene.meshes.empty() ? 0.0 : survey_model(scene).floor_m;
}

// From the newest place of the path the robot drove.
Camera robot_camera(const Scene& scene) {
  const PathItem* path = longest_path(scene);
  require(path != nullptr && !path->poses.empty(),
          "--camera robot: there is no trajectory to say where the robot is");
  return Walk(path->poses.back().world_from_robot, floor_of(scene)).camera();
}

ViewPlan plan_by_name(const Scene& scene, const RenderRequest& request) {
  if (request.camera.empty() || request.camera == "above")
    return plan_named_view(scene, View::above, request);
  if (request.camera == "front") return plan_named_view(scene, View::front, request);
  if (request.camera == "eye") return plan_named_view(scene, View::eye, request);
  ViewPlan plan{request.camera == "robot" ? robot_camera(scene) : parse_camera(request.camera),
                request.look};
  plan.camera.projection = request.projection;
  return plan;
}

// Once round, as one turns a doll's house in the hand.
std::vector<Camera> orbit_cameras(const Scene& scene, const RenderRequest& request) {
  constexpr int kPictures = 180;
  const Box box = scene.meshes.empty() ? bounding_box(scene) : survey_model(scene).box;
  Camera camera;
  camera.projection = request.projection;
  camera.field_of_view_rad = deg_to_rad(35.0);
  // One distance for all, that of the widest view: the model does not breathe.
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

std::vector<Camera> film_cameras(const Scene& scene, const RenderRequest& request) {
  constexpr double kStepM = 0.05;
  constexpr double kEyeHeightM = 1.0;
  const PathItem* path = longest_path(scene);
  if (path == nullptr || scene.meshes.empty()) return orbit_cameras(scene, request);
  return drive_cameras(path->poses, kStepM, floor_of(scene) + kEyeHeightM);
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
  const ViewPlan plan = plan_request(scene, request, renderer);
  const Picture picture = renderer.draw(plan.camera, plan.look, request.size);
  const bool outside =
      request.camera.empty() || request.camera == "above" || request.camera == "front";
  if (!outside) return picture;
  const Box box = scene.meshes.empty() ? bounding_box(scene) : survey_model(scene).box;
  return add_scale_bar(picture, plan.camera, box);
}

ViewPlan plan_request(const Scene& scene, const RenderRequest& request, Renderer& renderer) {
  ViewPlan plan = plan_by_name(scene, request);
  if (std::isfinite(request.cut_height_m)) plan.look.cut_height_m = request.cut_height_m;
  if (request.camera == "eye") {
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

int render_film(const Scene& scene, const RenderRequest& request, const std::string& path) {
  constexpr double kFramesPerSecond = 25.0;
  Renderer renderer;
  renderer.load(scene);
  const bool drives = longest_path(scene) != nullptr && !scene.meshes.empty();
  const Look look = drives ? request.look : plan_named_view(scene, View::above, request).look;
  FilmWriter film(path, request.size.width_px, request.size.height_px, kFramesPerSecond);
  for (const Camera& camera : film_cameras(scene, request))
    film.add(renderer.draw(camera, look, request.size));
  film.finish();
  return film.frame_count();
}

namespace {

Walk walk_from_start(const Scene& scene, const ViewPlan& eye) {
  const PathItem* path = longest_path(scene);
  Pose2 world_from_robot{eye.camera.eye_m.x(), eye.camera.eye_m.y(), 0.0};
  if (path != nullptr && !path->poses.empty())
    world_from_robot = path->poses.front().world_from_robot;
  return Walk(world_from_robot, floor_of(scene));
}

}  // namespace

int render_walk(const Scene& scene,
                const RenderRequest& request,
                const std::string& script,
                const std::string& folder) {
  const std::vector<WalkCommand> commands = parse_walk(script);
  Renderer renderer;
  renderer.load(scene);
  const ViewPlan start = plan_named_view(scene, View::eye, request);
  Walk walk = walk_from_start(scene, start);
  std::filesystem::create_directories(folder);
  int count = 0;
  const auto look_around = [&] {
    char name[32];
    std::snprintf(name, sizeof name, "%03d.png", count++);
    write_png(renderer.draw(walk.camera(), start.look, request.size),
              (std::filesystem::path(folder) / name).string());
  };
  look_around();
  for (const WalkCommand& command : commands) {
    walk.apply(command);
    look_around();
  }
  return count;
}

int render_walk_by_keys(const Scene& scene,
                        const RenderRequest& request,
                        const std::function<char()>& next_key,
                        const std::function<void(const Picture&)>& show) {
  constexpr double kDetailPx = 1.5;
  Renderer renderer;
  renderer.load(scene);
  ViewPlan start = plan_named_view(scene, View::eye, request);
  start.look.detail_px = kDetailPx;
  Walk walk = walk_from_start(scene, start);
  int count = 1;
  show(renderer.draw(walk.camera(), start.look, request.size));
  for (char key = next_key(); key != 0; key = next_key()) {
    if (!walk.press(key)) continue;
    show(renderer.draw(walk.camera(), start.look, request.size));
    ++count;
  }
  return count;
}

}  // namespace marco::viewer
