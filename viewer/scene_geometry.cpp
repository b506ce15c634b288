#include "viewer/scene_geometry.hpp"

#include <algorithm>
#include <cmath>

#include "viewer/standing_map.hpp"

namespace marco::viewer {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

std::array<uint8_t, 4> packed(Rgb color) { return {color.red, color.green, color.blue, 255}; }

Vertex make_vertex(const Vector3f& position, const Vector3f& normal, Rgb color) {
  Vertex vertex;
  vertex.position_m = {position.x(), position.y(), position.z()};
  vertex.set_normal(normal);
  vertex.color = packed(color);
  return vertex;
}

std::vector<Vector3f> area_weighted_normals(const TriangleMesh& mesh) {
  std::vector<Vector3f> normals(mesh.vertices_m.size(), Vector3f::Zero());
  for (const auto& triangle : mesh.triangles) {
    if (std::max({triangle[0], triangle[1], triangle[2]}) >= normals.size()) continue;
    const Vector3f& corner = mesh.vertices_m[triangle[0]];
    const Vector3f twice_area =
        (mesh.vertices_m[triangle[1]] - corner).cross(mesh.vertices_m[triangle[2]] - corner);
    if (!twice_area.allFinite()) continue;
    for (const uint32_t index : triangle) normals[index] += twice_area;
  }
  for (Vector3f& normal : normals) normal.normalize();
  return normals;
}

void add_mesh(const TriangleMesh& mesh, Rgb plain_color, Geometry& out) {
  const std::size_t count = mesh.vertices_m.size();
  const auto first = static_cast<uint32_t>(out.vertices.size());
  const std::vector<Vector3f> computed =
      mesh.normals.size() == count ? std::vector<Vector3f>{} : area_weighted_normals(mesh);
  const std::vector<Vector3f>& normals = computed.empty() ? mesh.normals : computed;
  out.vertices.reserve(out.vertices.size() + count);
  for (std::size_t i = 0; i < count; ++i) {
    Rgb color = plain_color;
    if (mesh.colors_rgb.size() == count)
      color = {mesh.colors_rgb[i][0], mesh.colors_rgb[i][1], mesh.colors_rgb[i][2]};
    out.vertices.push_back(make_vertex(mesh.vertices_m[i], normals[i], color));
  }
  out.indices.reserve(out.indices.size() + 3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    const bool good = std::all_of(triangle.begin(), triangle.end(), [&](uint32_t index) {
      return index < count && mesh.vertices_m[index].allFinite();
    });
    if (!good) continue;
    for (const uint32_t index : triangle) out.indices.push_back(first + index);
  }
}

// Corners in order round the face; the normal is right-handed to that order.
void add_polygon(const std::vector<Vector3d>& corners, Rgb color, Geometry& out) {
  const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  const auto first = static_cast<uint32_t>(out.vertices.size());
  for (const Vector3d& corner : corners)
    out.vertices.push_back(make_vertex(corner.cast<float>(), normal.cast<float>(), color));
  for (uint32_t i = 2; i < corners.size(); ++i)
    out.indices.insert(out.indices.end(), {first, first + i - 1, first + i});
}

// A six-sided bar between two points.
void add_bar(const Vector3d& from, const Vector3d& to, double radius_m, Rgb color, Geometry& out) {
  const Vector3d along = (to - from).normalized();
  if (!along.allFinite() || along.norm() < 0.5) return;
  const Vector3d helper = std::abs(along.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
  const Vector3d side = along.cross(helper).normalized(), upper = side.cross(along);
  constexpr uint32_t kSides = 6;
  const auto first = static_cast<uint32_t>(out.vertices.size());
  for (uint32_t i = 0; i < kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    const Vector3d outward = std::cos(angle) * side + std::sin(angle) * upper;
    for (const Vector3d& end : {from, to})
      out.vertices.push_back(
          make_vertex((end + radius_m * outward).cast<float>(), outward.cast<float>(), color));
  }
  for (uint32_t i = 0; i < kSides; ++i) {
    const uint32_t a = first + 2 * i, b = first + 2 * ((i + 1) % kSides);
    out.indices.insert(out.indices.end(), {a, b, a + 1, b, b + 1, a + 1});
  }
}

void add_path(const PathItem& item, double radius_m, Geometry& out) {
  std::vector<Vector3d> points;
  for (const StampedPose2& pose : item.poses) {
    if (!is_finite(pose.world_from_robot)) continue;
    const Vector3d point(pose.world_from_robot.x_m, pose.world_from_robot.y_m, 2.0 * radius_m);
    if (points.empty() || (point - points.back()).norm() > 2.0 * radius_m) points.push_back(point);
  }
  for (std::size_t i = 1; i < points.size(); ++i)
    if ((points[i] - points[i - 1]).norm() <= item.longest_step_m)
      add_bar(points[i - 1], points[i], radius_m, item.color, out);
}

void add_wall(const WallItem& wall, Geometry& out) {
  const Vector3d from(wall.from_m.x(), wall.from_m.y(), 0.0);
  const Vector3d to(wall.to_m.x(), wall.to_m.y(), 0.0);
  const Vector3d up(0.0, 0.0, wall.height_m);
  if ((to - from).norm() > 0.0) add_polygon({from, to, to + up, from + up}, wall.color, out);
}

void add_robot(const RobotItem& robot, Geometry& out) {
  constexpr int kCorners = 24;
  std::vector<Vector3d> top;
  for (int i = 0; i <= kCorners; ++i) {
    const double bearing = std::numbers::pi * (static_cast<double>(i) / kCorners - 0.5);
    const Eigen::Vector2d point =
        robot.world_from_robot *
        Eigen::Vector2d(robot.radius_m * std::cos(bearing), robot.radius_m * std::sin(bearing));
    top.emplace_back(point.x(), point.y(), robot.height_m);
  }
  add_polygon(top, robot.color, out);
  const Vector3d down(0.0, 0.0, -robot.height_m);
  for (std::size_t i = 0; i < top.size(); ++i) {
    const Vector3d &a = top[i], &b = top[(i + 1) % top.size()];
    add_polygon({a + down, b + down, b, a}, robot.color, out);
  }
}

void add_ellipse(const EllipseItem& item, double radius_m, Geometry& out) {
  const std::vector<Eigen::Vector2d> outline_m = item.outline_m();
  for (std::size_t i = 0; i + 1 < outline_m.size(); ++i) {
    const auto raised = [&](const Eigen::Vector2d& corner) {
      return Vector3d(corner.x(), corner.y(), 2.0 * radius_m);
    };
    add_bar(raised(outline_m[i]), raised(outline_m[i + 1]), radius_m, item.color, out);
  }
}

void add_single(const Vector3f& point, Rgb color, Geometry& out) {
  out.indices.push_back(static_cast<uint32_t>(out.vertices.size()));
  out.vertices.push_back(make_vertex(point, Vector3f::Zero(), color));
}

}  // namespace

void Vertex::set_normal(const Eigen::Vector3f& direction) {
  for (int axis = 0; axis < 3; ++axis) {
    const float part = std::isfinite(direction[axis]) ? direction[axis] : 0.0F;
    normal[static_cast<std::size_t>(axis)] =
        static_cast<int16_t>(std::lround(32767.0F * std::clamp(part, -1.0F, 1.0F)));
  }
}

SceneGeometry build_geometry(const Scene& scene) {
  SceneGeometry geometry;
  const Box box = bounding_box(scene);
  // Seen whole, a path is about three pixels wide.
  const double bar_radius_m =
      box.empty() ? 0.02 : std::clamp(0.0018 * box.size_m().norm(), 0.01, 0.2);
  for (const MeshItem& item : scene.meshes) add_mesh(*item.mesh, item.color, geometry.surfaces);
  if (scene.grid)
    add_mesh(standing_map(*scene.grid, scene.grid_wall_height_m), {}, geometry.surfaces);
  for (const WallItem& wall : scene.walls) add_wall(wall, geometry.props);
  for (const RobotItem& robot : scene.robots) add_robot(robot, geometry.props);
  for (const PathItem& path : scene.paths) add_path(path, bar_radius_m, geometry.props);
  for (const EllipseItem& item : scene.ellipses) add_ellipse(item, bar_radius_m, geometry.props);
  for (const PointsItem& item : scene.points)
    for (const Vector3f& point : item.points_m)
      if (point.allFinite()) add_single(point, item.color, geometry.points);
  for (const RaysItem& item : scene.rays) {
    for (const Vector3f& end : item.ends_m) {
      if (!end.allFinite()) continue;
      add_single(item.origin_m.cast<float>(), item.color, geometry.lines);
      add_single(end, item.color, geometry.lines);
    }
  }
  return geometry;
}

}  // namespace marco::viewer
