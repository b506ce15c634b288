#include "viewer/map_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lcm_tools/base/check.hpp"
#include "viewer/map_extent.hpp"
#include "viewer/standing_map.hpp"

namespace marco::viewer {
namespace {

constexpr double kMapEyeHeightM = 1.4;
constexpr int kBearings = 72;
constexpr int kSideBearings = 9;     // on each side of the heading: 45 deg
constexpr double kFarthestM = 12.0;  // farther makes no difference
constexpr double kClearanceM = 0.5;
constexpr std::size_t kMostPlaces = 400;

double bearing_rad(int index) { return 2.0 * std::numbers::pi * index / kBearings; }

bool is_free(const GridMap& grid, const Eigen::Vector2i& cell) {
  return grid.contains(cell.x(), cell.y()) && grid.at(cell.x(), cell.y()) < 50;
}

struct Sight {
  double free_m = 0.0;
  bool ends_at_wall = false;
};

Sight look_along(const GridMap& grid, const Eigen::Vector2d& from_m, double bearing) {
  const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
  Sight sight;
  for (; sight.free_m < kFarthestM; sight.free_m += 0.5 * grid.resolution_m) {
    const Eigen::Vector2i cell = grid.cell_of(from_m + sight.free_m * direction);
    if (is_free(grid, cell)) continue;
    sight.ends_at_wall = grid.contains(cell.x(), cell.y()) && is_occupied(grid, cell.x(), cell.y());
    break;
  }
  return sight;
}

struct Outlook {
  Pose2 world_from_eye;
  double worth = -1.0;
};

// A view that ends in unknown cells shows a hole there.
Outlook outlook_from(const GridMap& grid, const Eigen::Vector2d& place_m) {
  std::array<Sight, kBearings> sights;
  double nearest_m = kFarthestM;
  for (int i = 0; i < kBearings; ++i) {
    sights[i] = look_along(grid, place_m, bearing_rad(i));
    nearest_m = std::min(nearest_m, sights[i].free_m);
  }
  Outlook best;
  for (int heading = 0; heading < kBearings; ++heading) {
    double worth = sights[heading].free_m;
    for (int side = -kSideBearings; side <= kSideBearings; ++side) {
      const Sight& sight = sights[(heading + side + kBearings) % kBearings];
      worth += std::log1p(sight.free_m) * (sight.ends_at_wall ? 1.0 : -0.5);
    }
    worth *= std::min(nearest_m / kClearanceM, 1.0);
    if (worth > best.worth)
      best = {{place_m.x(), place_m.y(), normalize_angle(bearing_rad(heading))}, worth};
  }
  return best;
}

std::vector<Eigen::Vector2d> places_to_stand(const GridMap& grid, const Trajectory& path) {
  std::vector<Eigen::Vector2d> places;
  for (const StampedPose2& pose : path) {
    const Eigen::Vector2d place = pose.world_from_robot.translation_m();
    if (place.allFinite() && is_free(grid, grid.cell_of(place))) places.push_back(place);
  }
  if (!places.empty()) return places;
  for (int y = 0; y < grid.height_cells; ++y)
    for (int x = 0; x < grid.width_cells; ++x)
      if (is_free(grid, {x, y}))
        places.push_back(grid.origin_m +
                         grid.resolution_m * (Eigen::Vector2d(x, y).array() + 0.5).matrix());
  return places;
}

}  // namespace

Pose2 best_outlook(const GridMap& grid, const Trajectory& path) {
  const std::vector<Eigen::Vector2d> places = places_to_stand(grid, path);
  const std::size_t stride = 1 + places.size() / kMostPlaces;
  Outlook best;
  for (std::size_t i = 0; i < places.size(); i += stride) {
    const Outlook found = outlook_from(grid, places[i]);
    if (found.worth > best.worth) best = found;
  }
  return best.world_from_eye;
}

Box map_box(const GridMap& grid, double wall_height_m) {
  const auto extent = find_extent(grid);
  require(extent.has_value(), "nothing to draw: the map has no known cell");
  Box box;
  box.add((Eigen::Vector3d() << extent->min_m(grid), 0.0).finished());
  box.add((Eigen::Vector3d() << extent->max_m(grid), wall_height_m).finished());
  return box;
}

Look map_look(Look look, double wall_height_m) {
  look.height_range_m = {0.0, wall_height_m};
  look.back_faces = BackFaces::hide;
  return look;
}

ViewPlan plan_map_view(
    const Scene& scene, View view, const Look& look, Projection projection, PictureSize size) {
  ViewPlan plan;
  plan.look = map_look(look, scene.grid_wall_height_m);
  const Box box = map_box(*scene.grid, scene.grid_wall_height_m);
  if (view == View::eye) {
    const PathItem* path = driven_path(scene);
    const Pose2 place = best_outlook(*scene.grid, path == nullptr ? Trajectory{} : path->poses);
    plan.camera =
        camera_at(make_pose3({place.x_m, place.y_m, kMapEyeHeightM}, 0.0, 0.0, place.theta_rad));
    plan.camera.field_of_view_rad = deg_to_rad(65.0);
    plan.camera.view_height_m = 2.0 * scene.grid_wall_height_m;
    plan.camera.far_m = 4.0 * box.size_m().norm() + 10.0;
    plan.camera.projection = projection;
    return plan;
  }
  plan.camera.projection = projection;
  plan.camera.field_of_view_rad = deg_to_rad(35.0);
  const bool above = view == View::above;
  plan.camera = fit_camera(plan.camera, box, deg_to_rad(above ? -90.0 : -66.0),
                           deg_to_rad(above ? 64.0 : 28.0), size.aspect());
  return plan;
}

}  // namespace marco::viewer
