#include "slam/plan/make_plan.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/plan/free_space.hpp"
#include "slam/plan/openings.hpp"
#include "slam/plan/plan_objects.hpp"
#include "slam/plan/plan_walls.hpp"
#include "slam/plan/room_outline.hpp"
#include "slam/plan/room_raster.hpp"
#include "slam/plan/wall_faces.hpp"

namespace marco::slam {
namespace {

using Vector = Eigen::Vector2d;

// Of a time-of-flight laser's range scale; none of the maps can show its own.
constexpr double kScaleSigma = 0.001;

double sigma_of(const FloorPlan& plan, const RoomEdge& edge) {
  if (edge.kind == EdgeKind::wall && edge.index >= 0) {
    return plan.faces[static_cast<std::size_t>(edge.index)].sigma_m;
  }
  return edge.kind == EdgeKind::unseen ? 0.10 : 0.02;
}

// Clear size through a point, along x or y.
double clear_size(const PlanRoom& room, int axis) {
  double before = -1e9, after = 1e9;
  const int other = 1 - axis;
  for (std::size_t i = 0; i < room.edges.size(); ++i) {
    const Vector a = room.edges[i].from, b = room.edges[(i + 1) % room.edges.size()].from;
    const Vector& at = room.label_at;
    if ((a[other] > at[other]) == (b[other] > at[other])) continue;
    const double cut = a[axis] + (b[axis] - a[axis]) * (at[other] - a[other]) / (b[other] - a[other]);
    if (cut < at[axis]) before = std::max(before, cut);
    if (cut > at[axis]) after = std::min(after, cut);
  }
  return after - before < 1e6 ? after - before : 0.0;
}

void measure(const FloorPlan& plan, PlanRoom& room) {
  double twice = 0, known = 0, variance = 0;
  for (std::size_t i = 0; i < room.edges.size(); ++i) {
    const Vector a = room.edges[i].from, b = room.edges[(i + 1) % room.edges.size()].from;
    const double length = (b - a).norm();
    twice += a.x() * b.y() - a.y() * b.x();
    room.perimeter_m += length;
    if (room.edges[i].kind != EdgeKind::unseen) known += length;
    variance += std::pow(length * sigma_of(plan, room.edges[i]), 2);
  }
  room.area_m2 = twice / 2;
  room.area_sigma_m2 = std::sqrt(variance + std::pow(2 * plan.scale_sigma * room.area_m2, 2));
  room.seen = room.perimeter_m > 0 ? known / room.perimeter_m : 0.0;
  room.size_m = {clear_size(room, 0), clear_size(room, 1)};
}

}  // namespace

FloorPlan make_plan(const std::vector<Keyframe>& keys) {
  require(!keys.empty(), "a plan needs at least one keyframe");
  FloorPlan plan;
  plan.scale_sigma = kScaleSigma;
  const double direction = main_direction_rad(gather_surfels(keys, {}));
  plan.has_main_direction = std::isfinite(direction);
  if (plan.has_main_direction) plan.map_from_plan.theta_rad = direction;
  const Pose2 plan_from_map = plan.map_from_plan.inverse();
  const FreeSpace space(keys, plan_from_map);
  std::vector<PlanSurfel> surfels = gather_surfels(keys, plan_from_map);
  std::erase_if(surfels, [&](const PlanSurfel& surfel) { return space.is_free(surfel.mean()); });
  plan.faces = find_faces(surfels, plan.has_main_direction);
  plan.openings = find_openings(plan.faces, space);
  take_leaves(plan.faces, plan.openings, space);
  const RoomRaster raster = cut_rooms(space, plan.openings);
  for (int i = 0; i < raster.rooms; ++i) {
    PlanRoom room;
    room.edges = edges_of(outline_of(space, raster, i), plan.faces, plan.openings, raster, space);
    room.label_at = inmost_point(space, raster, i);
    measure(plan, room);
    plan.rooms.push_back(std::move(room));
  }
  std::erase_if(plan.rooms, [](const PlanRoom& room) { return room.area_m2 < 1.0; });
  std::stable_sort(plan.rooms.begin(), plan.rooms.end(), [](const PlanRoom& a, const PlanRoom& b) {
    const double row_a = std::round(-a.label_at.y() / 3), row_b = std::round(-b.label_at.y() / 3);
    return row_a != row_b ? row_a < row_b : a.label_at.x() < b.label_at.x();
  });
  int number = 0;
  for (PlanRoom& room : plan.rooms) room.name = "Room " + std::to_string(++number);
  plan.walls = walls_of(plan);
  plan.objects = find_objects(space, raster, surfels);
  return plan;
}

}  // namespace marco::slam
