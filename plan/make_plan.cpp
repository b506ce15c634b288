#include "plan/make_plan.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "plan/curved_faces.hpp"
#include "plan/free_space.hpp"
#include "plan/plan_steps.hpp"
#include "plan/room_raster.hpp"

namespace marco::plan {
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

// Clear size through the label, along x or y.
void measure_clear(PlanRoom& room, int axis) {
  double before = -1e9, after = 1e9;
  const int other = 1 - axis;
  for (const RoomEdge& edge : room.edges()) {
    std::vector<Vector> points = bulge_points(edge.from, edge.to, edge.bulge);
    points.push_back(edge.to);
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const Vector &a = points[i], &b = points[i + 1], &at = room.label_at;
      if ((a[other] > at[other]) == (b[other] > at[other])) continue;
      const double cut =
          a[axis] + (b[axis] - a[axis]) * (at[other] - a[other]) / (b[other] - a[other]);
      if (cut < at[axis]) before = std::max(before, cut);
      if (cut > at[axis]) after = std::min(after, cut);
    }
  }
  if (after - before > 1e6) return;
  room.size_m[axis] = after - before;
  room.size_from[axis] = before;
}

void measure(const FloorPlan& plan, PlanRoom& room) {
  double twice = 0, known = 0, variance = 0;
  for (const RoomEdge& edge : room.edges()) {
    const Vector a = edge.from, b = edge.to;
    const double length = edge.length_m();
    twice += a.x() * b.y() - a.y() * b.x() + 2 * bulge_area_m2(a, b, edge.bulge);
    room.perimeter_m += length;
    if (edge.kind != EdgeKind::unseen) known += length;
    variance += std::pow(length * sigma_of(plan, edge), 2);
  }
  room.area_m2 = twice / 2;
  room.area_sigma_m2 = std::sqrt(variance + std::pow(2 * plan.scale_sigma * room.area_m2, 2));
  room.seen = room.perimeter_m > 0 ? known / room.perimeter_m : 0.0;
  for (const int axis : {0, 1}) measure_clear(room, axis);
}

// People and doors that moved are not faces: beams went through where they stood. Glass stays:
// long, and seen from many places.
bool is_passing(WallFace& face, const FreeSpace& space) {
  int free = 0, all = 0;
  for (double s = face.low_m; s <= face.high_m; s += 0.05, ++all) free += space.is_free(face.at(s));
  if (free < 0.3 * all) return false;
  face.glass = face.length_m() > 0.8 && face.keyframes >= 4;
  return !face.glass;
}

// Normals of points tell the direction to half a degree; long faces tell it to hundredths.
double remaining_turn(const std::vector<WallFace>& faces) {
  double sum = 0, weights = 0;
  for (const WallFace& face : faces) {
    const double turn =
        std::remainder(std::atan2(face.normal.y(), face.normal.x()), std::numbers::pi / 2);
    if (std::abs(turn) > deg_to_rad(1.5)) continue;
    const double weight = std::pow(face.angle_sigma_rad + 1e-4, -2);
    sum += weight * turn;
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0.0;
}

}  // namespace

FloorPlan make_plan(const std::vector<slam::Keyframe>& keys) {
  require(!keys.empty(), "a plan needs at least one keyframe");
  FloorPlan plan;
  plan.scale_sigma = kScaleSigma;
  const double direction = main_direction_rad(gather_surfels(keys, {}));
  plan.has_main_direction = std::isfinite(direction);
  if (plan.has_main_direction) {
    const Pose2 map_from_rough{0, 0, direction};
    plan.map_from_plan.theta_rad =
        direction +
        remaining_turn(find_faces(gather_surfels(keys, map_from_rough.inverse()), false));
  }
  const Pose2 plan_from_map = plan.map_from_plan.inverse();
  FreeSpace space(keys, plan_from_map);
  const std::vector<PlanSurfel> surfels = gather_surfels(keys, plan_from_map);
  CurvedFaces curved = find_curved_faces(surfels);
  plan.arcs = std::move(curved.arcs);
  measure_arcs(keys, plan_from_map, plan.arcs);
  plan.faces = find_faces(surfels, plan.has_main_direction, std::move(curved.taken));
  const std::vector<WallFace> chords = chords_of_arcs(plan.arcs);
  plan.faces.insert(plan.faces.end(), chords.begin(), chords.end());
  std::erase_if(plan.faces, [&](WallFace& face) { return is_passing(face, space); });
  for (const WallFace& face : plan.faces) {
    if (face.glass) space.close(face.at(face.low_m), face.at(face.high_m));
  }
  space.smooth();
  plan.openings = find_openings(plan, space);
  take_leaves(plan.faces, plan.openings, space);
  const RoomRaster raster = cut_rooms(space, plan.openings);
  for (int i = 0; i < raster.rooms; ++i) {
    PlanRoom room;
    for (const auto& outline : outlines_of(space, raster, i, kLargestObjectM)) {
      room.loops.push_back(edges_of(outline, plan, raster, space));
    }
    room.label_at = inmost_point(space, raster, i);
    measure(plan, room);
    plan.rooms.push_back(std::move(room));
  }
  // What only shows through a gap or a pane, without a wall, is no room.
  std::erase_if(plan.rooms,
                [](const PlanRoom& room) { return room.area_m2 < 1.0 || room.seen < 0.1; });
  std::stable_sort(plan.rooms.begin(), plan.rooms.end(), [](const PlanRoom& a, const PlanRoom& b) {
    const double row_a = std::round(-a.label_at.y() / 3), row_b = std::round(-b.label_at.y() / 3);
    return row_a != row_b ? row_a < row_b : a.label_at.x() < b.label_at.x();
  });
  int number = 0;
  for (PlanRoom& room : plan.rooms) room.name = "Room " + std::to_string(++number);
  plan.walls = walls_of(plan);
  std::vector<PlanObject> free_standing = find_objects(space, raster, surfels);
  measure_round(keys, plan_from_map, free_standing);
  std::move(free_standing.begin(), free_standing.end(), std::back_inserter(plan.objects));
  return plan;
}

}  // namespace marco::plan
