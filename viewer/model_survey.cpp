#include "viewer/model_survey.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "lcm_tools/base/check.hpp"

namespace marco::viewer {
namespace {

using Eigen::Vector3d;

constexpr double kCellM = 0.4;
constexpr double kLevelBinM = 0.05;
constexpr double kLeastRoomHeightM = 1.6;
// A survey samples every Nth triangle: its cost does not depend on the model.
constexpr std::size_t kSurveyedTriangles = 100000;

struct Patch {
  std::array<Vector3d, 3> corners_m;
  Vector3d middle_m;
  Vector3d normal;
  double area_m2;
};

std::vector<Patch> patches_of(const Scene& scene) {
  std::vector<Patch> patches;
  std::size_t count = 0;
  for (const MeshItem& item : scene.meshes) count += item.mesh->triangles.size();
  const std::size_t stride = 1 + count / kSurveyedTriangles;
  for (const MeshItem& item : scene.meshes) {
    const auto& vertices = item.mesh->vertices_m;
    for (std::size_t i = 0; i < item.mesh->triangles.size(); i += stride) {
      const auto& triangle = item.mesh->triangles[i];
      if (std::max({triangle[0], triangle[1], triangle[2]}) >= vertices.size()) continue;
      const Vector3d a = vertices[triangle[0]].cast<double>();
      const Vector3d b = vertices[triangle[1]].cast<double>();
      const Vector3d c = vertices[triangle[2]].cast<double>();
      const Vector3d twice = (b - a).cross(c - a);
      const double area = 0.5 * twice.norm();
      if (std::isfinite(area) && area > 0.0)
        patches.push_back({{a, b, c}, (a + b + c) / 3.0, twice.normalized(), area});
    }
  }
  return patches;
}

double total_area(const std::vector<Patch>& patches) {
  double sum = 0.0;
  for (const Patch& patch : patches) sum += patch.area_m2;
  return sum;
}

// The box of all but the outermost part of the surface, a side at a time.
Box box_without_strays(std::vector<Patch> patches, double stray_part) {
  const double allowed = stray_part * total_area(patches);
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(patches.begin(), patches.end(), [axis](const Patch& a, const Patch& b) {
      return a.middle_m[axis] < b.middle_m[axis];
    });
    double outside = 0.0;
    for (const Patch& patch : patches) {
      box.min_m[axis] = patch.middle_m[axis];
      if ((outside += patch.area_m2) > allowed) break;
    }
    outside = 0.0;
    for (auto patch = patches.rbegin(); patch != patches.rend(); ++patch) {
      box.max_m[axis] = patch->middle_m[axis];
      if ((outside += patch->area_m2) > allowed) break;
    }
  }
  return box;
}

using Cell = std::pair<int, int>;

Cell cell_of(const Vector3d& point_m) {
  return {static_cast<int>(std::floor(point_m.x() / kCellM)),
          static_cast<int>(std::floor(point_m.y() / kCellM))};
}

// Large triangles span many cells.
void mark_line(const Vector3d& from, const Vector3d& to, std::set<Cell>& cells) {
  const int steps = static_cast<int>(std::min((to - from).head<2>().norm() / kCellM, 200.0)) + 1;
  for (int i = 0; i <= steps; ++i)
    cells.insert(cell_of(from + (to - from) * (static_cast<double>(i) / steps)));
}

// The part of the ground plan with the most connected cells.
std::set<Cell> largest_part(std::set<Cell> cells) {
  std::set<Cell> largest;
  while (!cells.empty()) {
    std::set<Cell> part;
    std::vector<Cell> open{*cells.begin()};
    cells.erase(cells.begin());
    while (!open.empty()) {
      const Cell cell = open.back();
      open.pop_back();
      part.insert(cell);
      for (int dx = -1; dx <= 1; ++dx) {
        for (int dy = -1; dy <= 1; ++dy) {
          const auto neighbour = cells.find({cell.first + dx, cell.second + dy});
          if (neighbour == cells.end()) continue;
          open.push_back(*neighbour);
          cells.erase(neighbour);
        }
      }
    }
    if (part.size() > largest.size()) largest = std::move(part);
  }
  return largest;
}

// What a laser saw through a window or a mirror lies apart and would make the picture small.
std::vector<Patch> without_islands(const std::vector<Patch>& patches) {
  std::set<Cell> cells;
  for (const Patch& patch : patches)
    for (const Vector3d& corner : patch.corners_m) mark_line(patch.middle_m, corner, cells);
  const std::set<Cell> rooms = largest_part(std::move(cells));
  std::vector<Patch> kept;
  for (const Patch& patch : patches)
    if (rooms.contains(cell_of(patch.middle_m))) kept.push_back(patch);
  return kept;
}

struct Level {
  double area_m2 = 0.0;
  double facing_up_m2 = 0.0;
};

std::map<int, Level> level_surfaces(const std::vector<Patch>& patches) {
  std::map<int, Level> levels;
  for (const Patch& patch : patches) {
    if (std::abs(patch.normal.z()) < 0.85) continue;
    Level& level = levels[static_cast<int>(std::floor(patch.middle_m.z() / kLevelBinM))];
    level.area_m2 += patch.area_m2;
    if (patch.normal.z() > 0.0) level.facing_up_m2 += patch.area_m2;
  }
  return levels;
}

void find_floor_and_ceiling(const std::vector<Patch>& patches, ModelSurvey& survey) {
  const std::map<int, Level> levels = level_surfaces(patches);
  double largest = 0.0;
  for (const auto& [bin, level] : levels) largest = std::max(largest, level.area_m2);
  survey.floor_m = survey.box.min_m.z();
  const auto is_large = [largest](const std::pair<const int, Level>& entry) {
    return entry.second.area_m2 > 0.2 * largest;
  };
  const auto floor = std::find_if(levels.begin(), levels.end(), is_large);
  if (floor == levels.end()) return;
  survey.floor_m = floor->first * kLevelBinM;
  // A floor is rarely level to one bin: what lies a little above belongs to it.
  double area = 0.0, up = 0.0;
  for (auto level = floor; level != levels.end() && level->first <= floor->first + 4; ++level) {
    area += level->second.area_m2;
    up += level->second.facing_up_m2;
  }
  survey.visible_from_inside = up > 0.9 * area;
  const auto ceiling = std::find_if(levels.rbegin(), levels.rend(), is_large);
  if ((ceiling->first - floor->first) * kLevelBinM > kLeastRoomHeightM)
    survey.ceiling_m = ceiling->first * kLevelBinM;
}

}  // namespace

ModelSurvey survey_model(const Scene& scene) {
  const std::vector<Patch> all = patches_of(scene);
  require(!all.empty(), "the model has no triangle with an area: nothing to draw");
  const std::vector<Patch> rooms = without_islands(all);
  ModelSurvey survey;
  survey.box = box_without_strays(rooms, 0.005);
  find_floor_and_ceiling(rooms, survey);
  return survey;
}

double facing_wall_area_m2(const Scene& scene, const Eigen::Vector3d& towards_eye) {
  double sum = 0.0;
  for (const Patch& patch : patches_of(scene))
    if (std::abs(patch.normal.z()) < 0.5)
      sum += patch.area_m2 * std::max(patch.normal.dot(towards_eye), 0.0);
  return sum;
}

}  // namespace marco::viewer
