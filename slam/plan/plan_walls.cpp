#include "slam/plan/plan_walls.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

using Vector = Eigen::Vector2d;

constexpr double kThickestWallM = 0.60;  // old stone walls; farther faces are of two rooms
constexpr double kAssumedM = 0.10;       // thickness of a wall of which one side was seen
constexpr double kLeastOverlapM = 0.15;  // of two faces: three cells of the map

struct Stretch {
  Vector from, to, normal;
  double offset() const { return normal.dot(from); }
};

}  // namespace

std::vector<PlanWall> walls_of(const FloorPlan& plan) {
  std::vector<Stretch> stretches;
  for (const PlanRoom& room : plan.rooms) {
    for (const RoomEdge& edge : room.edges()) {
      if (edge.kind != EdgeKind::wall) continue;
      const Vector a = edge.from, b = edge.to;
      const Vector way = (b - a).normalized();
      stretches.push_back({a, b, {-way.y(), way.x()}});
    }
  }
  std::vector<PlanWall> walls;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const Stretch& one = stretches[i];
    const Vector way = (one.to - one.from).normalized();
    const double length = (one.to - one.from).norm();
    std::vector<std::pair<double, double>> paired;
    for (std::size_t k = 0; k < stretches.size(); ++k) {
      const Stretch& other = stretches[k];
      if (k == i || one.normal.dot(other.normal) > -0.98) continue;
      const double low = std::max(0.0, way.dot(other.to - one.from));
      const double high = std::min(length, way.dot(other.from - one.from));
      if (high - low < std::min(kLeastOverlapM, length / 2)) continue;
      const Vector middle = one.from + way * ((low + high) / 2);
      const double thickness = other.normal.dot(middle - other.from) * -1.0;
      if (thickness < -0.04 || thickness > kThickestWallM) continue;
      paired.emplace_back(low, high);
      if (i < k) {
        walls.push_back({one.from + way * low, one.from + way * high, one.normal,
                         std::max(0.0, thickness), false});
      }
    }
    std::sort(paired.begin(), paired.end());
    double at = 0;
    paired.emplace_back(length, length);
    for (const auto& [low, high] : paired) {
      if (low - at > 0.02) {
        walls.push_back({one.from + way * at, one.from + way * low, one.normal, kAssumedM, true});
      }
      at = std::max(at, high);
    }
  }
  return walls;
}

}  // namespace marco::slam
