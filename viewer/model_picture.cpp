#include "viewer/model_picture.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "viewer/canvas.hpp"
#include "viewer/map_border.hpp"
#include "viewer/map_view.hpp"
#include "viewer/shading.hpp"

namespace marco::viewer {
namespace {

using Eigen::Vector3d;

constexpr double kEyeHeightM = 1.25;

// Across the longer side, slightly from a corner: shows depth and fills the picture.
double slanted_azimuth_rad(const Box& box) {
  const bool long_in_x = box.size_m().x() >= box.size_m().y();
  return deg_to_rad(long_in_x ? -90.0 + 24.0 : 24.0);
}

// Where the outsides of walls are faint: from the side with the largest visible wall area.
double azimuth_towards_walls_rad(const Scene& scene, const Box& box) {
  double best = slanted_azimuth_rad(box), most_m2 = -1.0;
  for (const double turn_deg : {0.0, 180.0, -48.0, 132.0}) {
    const double azimuth = slanted_azimuth_rad(box) + deg_to_rad(turn_deg);
    // A difference of 1 % is not visible: the first one is kept.
    const double area_m2 = facing_wall_area_m2(scene, {std::cos(azimuth), std::sin(azimuth), 0.0});
    if (area_m2 <= 1.01 * most_m2) continue;
    most_m2 = area_m2;
    best = azimuth;
  }
  return best;
}

Vector3d place_to_look_from(const Scene& scene, const ModelSurvey& survey) {
  const PathItem* path = driven_path(scene);
  const double height_m = survey.floor_m + kEyeHeightM;
  if (path != nullptr) {
    const Pose2& pose = path->poses[path->poses.size() / 2].world_from_robot;
    return {pose.x_m, pose.y_m, height_m};
  }
  return {survey.box.center_m().x(), survey.box.center_m().y(), height_m};
}

double text_height_px(const Picture& picture) {
  return std::clamp(picture.height_px / 52.0, 9.0, 60.0);
}

}  // namespace

const PathItem* driven_path(const Scene& scene) {
  const PathItem* driven = nullptr;
  for (const PathItem& path : scene.paths) {
    if (path.poses.empty()) continue;
    if (path.label == "estimate") return &path;
    if (driven == nullptr || path.poses.size() > driven->poses.size()) driven = &path;
  }
  return driven;
}

ViewPlan plan_view(
    const Scene& scene, View view, const Look& look, Projection projection, PictureSize size) {
  if (scene.meshes.empty() && scene.grid) return plan_map_view(scene, view, look, projection, size);
  ViewPlan plan;
  plan.look = look;
  plan.camera.projection = projection;
  if (scene.meshes.empty()) {
    const Box box = bounding_box(scene);
    plan.camera.field_of_view_rad = deg_to_rad(40.0);
    plan.camera =
        fit_camera(plan.camera, box, slanted_azimuth_rad(box), deg_to_rad(55.0), size.aspect());
    return plan;
  }
  const ModelSurvey survey = survey_model(scene);
  Box box = survey.box;
  plan.look.height_range_m = {survey.floor_m, survey.ceiling_m.value_or(box.max_m.z())};
  if (view == View::eye) {
    const Vector3d eye = place_to_look_from(scene, survey);
    plan.camera = camera_at(make_pose3(eye));
    plan.camera.projection = projection;
    plan.camera.view_height_m = box.size_m().z();
    plan.camera.far_m = 4.0 * box.size_m().norm() + 10.0;
    return plan;
  }
  double azimuth_rad = slanted_azimuth_rad(box);
  if (survey.visible_from_inside) {
    plan.look.back_faces = BackFaces::faint;
    azimuth_rad = azimuth_towards_walls_rad(scene, box);
  }
  plan.camera.field_of_view_rad = deg_to_rad(35.0);
  double elevation_rad = deg_to_rad(14.0);
  if (view == View::above) {
    elevation_rad = deg_to_rad(52.0);
    if (survey.ceiling_m) {
      plan.look.cut_height_m = survey.floor_m + 0.8 * (*survey.ceiling_m - survey.floor_m);
      box.max_m.z() = std::min(box.max_m.z(), plan.look.cut_height_m);
    }
  }
  plan.camera = fit_camera(plan.camera, box, azimuth_rad, elevation_rad, size.aspect());
  return plan;
}

double best_heading_rad(Renderer& renderer, const Eigen::Vector3d& eye_m) {
  constexpr PictureSize kSmall{96, 54};
  constexpr int kHeadings = 16;
  Look look;
  look.supersampling = 1;
  double best = -1.0, best_heading = 0.0;
  for (int i = 0; i < kHeadings; ++i) {
    const double heading = 2.0 * std::numbers::pi * i / kHeadings;
    const Camera camera = camera_at(make_pose3(eye_m, 0.0, 0.0, heading));
    double worth = 0.0;
    for (const float depth_m : renderer.draw_depth_m(camera, look, kSmall))
      if (std::isfinite(depth_m)) worth += std::log1p(std::min(static_cast<double>(depth_m), 12.0));
    if (worth > best) {
      best = worth;
      best_heading = heading;
    }
  }
  return normalize_angle(best_heading);
}

Picture add_scale_bar(const Picture& picture, const Camera& camera, const Box& box) {
  const double length_m = round_length(std::max(box.size_m().head<2>().maxCoeff() / 5.0, 1e-3));
  const Vector3d towards_eye = camera.eye_m - box.center_m();
  const bool along_x = std::abs(towards_eye.y()) >= std::abs(towards_eye.x());
  // The corner at the left of the edge that is nearest to the eye.
  Vector3d from(towards_eye.x() > 0.0 ? box.max_m.x() : box.min_m.x(),
                towards_eye.y() > 0.0 ? box.max_m.y() : box.min_m.y(), box.min_m.z());
  Vector3d along = Vector3d::Zero();
  if (along_x) {
    along.x() = towards_eye.y() > 0.0 ? -length_m : length_m;
    from.x() = towards_eye.y() > 0.0 ? box.max_m.x() : box.min_m.x();
    from.y() += towards_eye.y() > 0.0 ? 0.25 : -0.25;
  } else {
    along.y() = towards_eye.x() > 0.0 ? length_m : -length_m;
    from.y() = towards_eye.x() > 0.0 ? box.min_m.y() : box.max_m.y();
    from.x() += towards_eye.x() > 0.0 ? 0.25 : -0.25;
  }
  const Vector3d begin = project(camera, from, picture.width_px, picture.height_px);
  const Vector3d end = project(camera, from + along, picture.width_px, picture.height_px);
  const double text_px = text_height_px(picture);
  const auto inside = [&](const Vector3d& point) {
    return point.z() > 0.0 && point.x() >= 0.0 && point.x() < picture.width_px &&
           point.y() >= 0.0 && point.y() < picture.height_px;
  };
  if (!inside(begin) || !inside(end)) return picture;
  Canvas canvas(picture);
  canvas.draw_line(begin.head<2>(), end.head<2>(), palette::kText, 0.3 * text_px);
  const std::string label = length_label(length_m);
  const Eigen::Vector2d middle = 0.5 * (begin + end).head<2>();
  const bool room_below = middle.y() + 2.4 * text_px < picture.height_px;
  canvas.draw_text(label,
                   {middle.x() - 0.5 * Canvas::text_width_px(label, text_px),
                    middle.y() + (room_below ? 1.6 : -1.6) * text_px},
                   text_px, palette::kText);
  return canvas.finish();
}

Picture add_height_legend(const Picture& picture, const std::array<double, 2>& range_m) {
  const double text_px = text_height_px(picture);
  const std::string highest = length_label(range_m[1] - range_m[0]), lowest = "0";
  const double bar_px = 8.0 * text_px, margin_px = 1.5 * text_px;
  const double left_px =
      picture.width_px - margin_px - Canvas::text_width_px(highest, text_px) - 1.5 * text_px;
  const double bottom_px = picture.height_px - margin_px;
  Canvas canvas(picture);
  const int lines = static_cast<int>(std::ceil(bar_px));
  for (int i = 0; i < lines; ++i) {
    const Vector3d color = 255.0 * height_color((i + 0.5) / lines);
    canvas.fill_rectangle({left_px, bottom_px - i - 1.0}, {left_px + text_px, bottom_px - i},
                          {static_cast<uint8_t>(color.x()), static_cast<uint8_t>(color.y()),
                           static_cast<uint8_t>(color.z())});
  }
  const double words_px = left_px + 1.5 * text_px;
  canvas.draw_text(highest, {words_px, bottom_px - lines + 0.5 * text_px}, text_px, palette::kText);
  canvas.draw_text(lowest, {words_px, bottom_px - 0.5 * text_px}, text_px, palette::kText);
  return canvas.finish();
}

}  // namespace marco::viewer
