#include "simulator/world.hpp"

#include <cmath>
#include <numbers>

#include "common/pose2.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::sim {
namespace {

constexpr double kTopThicknessM = 0.03;
constexpr double kLegM = 0.05;

// Points on a circle: flat sides whose outline stays within kRoundnessM of it, on both sides of it.
class Circle {
 public:
  static constexpr double kRoundnessM = 0.0002;

  Circle(
      const Eigen::Vector2d& centre, double radius_m, double from_rad, double to_rad, int sides = 0)
      : centre_(centre), from_rad_(from_rad), sides_(sides) {
    // Corners lie outside the circle by as much as the middles of the sides lie inside.
    if (sides == 0) {
      const double half_side_rad = 2.0 * std::sqrt(kRoundnessM / radius_m);
      const double count = std::ceil(0.25 * (to_rad - from_rad) / std::min(0.7, half_side_rad));
      sides_ = 2 * std::max(1, static_cast<int>(count));
    }
    side_rad_ = (to_rad - from_rad) / sides_;
    corner_m_ = 2.0 * radius_m / (1.0 + std::cos(0.5 * side_rad_));
  }

  int sides() const { return sides_; }  ///< even
  Eigen::Vector3d at(int corner, double z) const {
    const double angle = from_rad_ + side_rad_ * corner;
    return {centre_.x() + corner_m_ * std::cos(angle), centre_.y() + corner_m_ * std::sin(angle),
            z};
  }

 private:
  Eigen::Vector2d centre_;
  double from_rad_, side_rad_ = 0.0, corner_m_ = 0.0;
  int sides_;
};

Eigen::Vector2d point(const std::vector<double>& values, const char* what) {
  require(values.size() == 2, std::string(what) + ": expected two numbers, x and y");
  return {values[0], values[1]};
}

void add_wall(World& world, const WallSpec& spec) {
  require(spec.corners_m.size() >= 4 && spec.corners_m.size() % 2 == 0,
          "walls.corners_m: expected x1, y1, x2, y2, ...");
  const Material material = material_named(spec.material);
  for (std::size_t i = 0; i + 3 < spec.corners_m.size(); i += 2) {
    const Eigen::Vector2d from(spec.corners_m[i], spec.corners_m[i + 1]);
    const Eigen::Vector2d to(spec.corners_m[i + 2], spec.corners_m[i + 3]);
    const Eigen::Vector2d along = to - from, middle = 0.5 * (from + to);
    // Longer by its thickness, so that corners close.
    world.add_box({middle.x(), middle.y(), 0.5 * spec.height_m},
                  {along.norm() + spec.thickness_m, spec.thickness_m, spec.height_m},
                  std::atan2(along.y(), along.x()), material);
  }
}

void add_arc(World& world, const ArcSpec& spec) {
  require(spec.to_deg > spec.from_deg && spec.to_deg <= spec.from_deg + 360.0,
          "arcs.to_deg: expected more than from_deg, by 360 at most");
  require(spec.thickness_m < 2.0 * spec.radius_m,
          "arcs.thickness_m: expected less than twice radius_m");
  world.add_arc(point(spec.centre_m, "arcs.centre_m"), spec.radius_m, deg_to_rad(spec.from_deg),
                deg_to_rad(spec.to_deg), {spec.height_m, spec.thickness_m},
                material_named(spec.material));
}

void add_table(World& world, const TableSpec& spec) {
  require(spec.size_m.size() == 2, "tables.size_m: expected two numbers");
  const Pose2 pose{point(spec.at_m, "tables.at_m").x(), point(spec.at_m, "tables.at_m").y(),
                   deg_to_rad(spec.yaw_deg)};
  const double x = spec.size_m[0], y = spec.size_m[1];
  const auto part = [&](const Eigen::Vector2d& at, double z, const Eigen::Vector3d& size) {
    const Eigen::Vector2d centre = pose * at;
    world.add_box({centre.x(), centre.y(), z}, size, pose.theta_rad, Material::plain);
  };
  part({0, 0}, spec.height_m - 0.5 * kTopThicknessM, {x, y, kTopThicknessM});
  const double leg_m = spec.height_m - kTopThicknessM;
  for (const double sx : {-0.5, 0.5}) {
    for (const double sy : {-0.5, 0.5}) {
      part({sx * (x - kLegM), sy * (y - kLegM)}, 0.5 * leg_m, {kLegM, kLegM, leg_m});
    }
  }
  if (spec.back_m > 0.0) {
    part({-0.5 * (x - kTopThicknessM), 0}, spec.height_m + 0.5 * spec.back_m,
         {kTopThicknessM, y, spec.back_m});
  }
}

void add_door(World& world, const DoorSpec& spec) {
  constexpr double kLeafM = 0.04;
  const double yaw = deg_to_rad(spec.closed_yaw_deg + spec.open_deg);
  const Eigen::Vector2d middle = point(spec.hinge_m, "doors.hinge_m") +
                                 0.5 * spec.width_m * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
  world.add_box({middle.x(), middle.y(), 0.5 * spec.height_m},
                {spec.width_m, kLeafM, spec.height_m}, yaw, material_named(spec.material));
}

Person person_of(const PersonSpec& spec) {
  const std::vector<double>& values = spec.waypoints_m;
  require(values.size() % 2 == 0, "people.waypoints_m: expected x1, y1, x2, y2, ...");
  std::vector<Eigen::Vector2d> waypoints_m;
  for (std::size_t i = 0; i < values.size(); i += 2) {
    waypoints_m.emplace_back(values[i], values[i + 1]);
  }
  return {waypoints_m, spec.speed_m_per_s, spec.ahead_s};
}

}  // namespace

Material material_named(const std::string& name) {
  if (name == "plain") return Material::plain;
  if (name == "black") return Material::black;
  if (name == "glass") return Material::glass;
  require(name == "mirror", "material '" + name + "' is not known: plain, black, glass or mirror");
  return Material::mirror;
}

void World::add_quad(const std::array<Eigen::Vector3d, 4>& corners, Material material) {
  const auto first = static_cast<uint32_t>(vertices_m.size());
  for (const Eigen::Vector3d& corner : corners) vertices_m.push_back(corner.cast<float>());
  triangles.push_back({first, first + 1, first + 2});
  triangles.push_back({first, first + 2, first + 3});
  materials.insert(materials.end(), 2, material);
}

void World::add_box(const Eigen::Vector3d& centre,
                    const Eigen::Vector3d& size,
                    double yaw_rad,
                    Material material) {
  const Pose2 pose{centre.x(), centre.y(), yaw_rad};
  const auto corner = [&](int x, int y, int z) -> Eigen::Vector3d {
    const Eigen::Vector2d at = pose * Eigen::Vector2d(0.5 * x * size.x(), 0.5 * y * size.y());
    return {at.x(), at.y(), centre.z() + 0.5 * z * size.z()};
  };
  for (const int s : {-1, 1}) {
    add_quad({corner(s, -1, -1), corner(s, 1, -1), corner(s, 1, 1), corner(s, -1, 1)}, material);
    add_quad({corner(-1, s, -1), corner(1, s, -1), corner(1, s, 1), corner(-1, s, 1)}, material);
    add_quad({corner(-1, -1, s), corner(1, -1, s), corner(1, 1, s), corner(-1, 1, s)}, material);
  }
}

void World::add_column(const Eigen::Vector2d& centre,
                       double radius_m,
                       double height_m,
                       Material material) {
  const Circle circle(centre, radius_m, 0.0, 2.0 * std::numbers::pi);
  const Eigen::Vector3d top(centre.x(), centre.y(), height_m);
  for (int side = 0; side < circle.sides(); side += 2) {
    for (const int i : {side, side + 1}) {
      add_quad({circle.at(i, 0.0), circle.at(i + 1, 0.0), circle.at(i + 1, height_m),
                circle.at(i, height_m)},
               material);
    }
    add_quad({top, circle.at(side, height_m), circle.at(side + 1, height_m),
              circle.at(side + 2, height_m)},
             material);
  }
}

void World::add_arc(const Eigen::Vector2d& centre,
                    double radius_m,
                    double from_rad,
                    double to_rad,
                    const WallSize& size,
                    Material material) {
  const Circle outer(centre, radius_m + 0.5 * size.thickness_m, from_rad, to_rad);
  const Circle inner(centre, radius_m - 0.5 * size.thickness_m, from_rad, to_rad, outer.sides());
  const double top = size.height_m;
  for (int i = 0; i < outer.sides(); ++i) {
    for (const Circle* face : {&outer, &inner}) {
      add_quad({face->at(i, 0), face->at(i + 1, 0), face->at(i + 1, top), face->at(i, top)},
               material);
    }
    add_quad({inner.at(i, top), outer.at(i, top), outer.at(i + 1, top), inner.at(i + 1, top)},
             material);
  }
  for (const int i : {0, outer.sides()}) {
    add_quad({inner.at(i, 0), outer.at(i, 0), outer.at(i, top), inner.at(i, top)}, material);
  }
}

World build_world(const WorldSpec& spec) {
  require(spec.floor_m.size() == 4 && spec.floor_m[2] > spec.floor_m[0] &&
              spec.floor_m[3] > spec.floor_m[1],
          "floor_m: expected x0, y0, x1, y1 with x1 > x0 and y1 > y0");
  World world;
  for (const double z : {0.0, spec.ceiling_m}) {
    world.add_quad({Eigen::Vector3d(spec.floor_m[0], spec.floor_m[1], z),
                    Eigen::Vector3d(spec.floor_m[2], spec.floor_m[1], z),
                    Eigen::Vector3d(spec.floor_m[2], spec.floor_m[3], z),
                    Eigen::Vector3d(spec.floor_m[0], spec.floor_m[3], z)},
                   Material::plain);
  }
  for (const WallSpec& wall : spec.walls) add_wall(world, wall);
  for (const ArcSpec& arc : spec.arcs) add_arc(world, arc);
  for (const BoxSpec& box : spec.boxes) {
    require(box.size_m.size() == 3, "boxes.size_m: expected three numbers");
    const Eigen::Vector2d at = point(box.at_m, "boxes.at_m");
    world.add_box({at.x(), at.y(), box.above_floor_m + 0.5 * box.size_m[2]},
                  {box.size_m[0], box.size_m[1], box.size_m[2]}, deg_to_rad(box.yaw_deg),
                  material_named(box.material));
  }
  for (const TableSpec& table : spec.tables) add_table(world, table);
  for (const DoorSpec& door : spec.doors) add_door(world, door);
  for (const ColumnSpec& column : spec.columns) {
    world.add_column(point(column.at_m, "columns.at_m"), column.radius_m, column.height_m,
                     Material::plain);
  }
  for (const PersonSpec& person : spec.people) world.people.push_back(person_of(person));
  return world;
}

}  // namespace marco::sim
