#include "plan/plan_steps.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

constexpr double kThickestWallM = 0.60;  // old stone walls; farther faces are of two rooms
constexpr double kAssumedM = 0.10;       // thickness of a wall of which one side was seen
constexpr double kLeastOverlapM = 0.15;  // of two faces: three cells of the map

// What no other face lies behind, between what is `paired`: where it begins and ends.
std::vector<std::pair<double, double>> rest_of(std::vector<std::pair<double, double>> paired,
                                               double length) {
  std::vector<std::pair<double, double>> rest;
  std::sort(paired.begin(), paired.end());
  paired.emplace_back(length, length);
  double at = 0;
  for (const auto& [low, high] : paired) {
    if (low > at) rest.emplace_back(at, low);
    at = std::max(at, high);
  }
  return rest;
}

struct CurvedStretch {
  Vector centre;
  double radius, from_rad, span_rad;  // counter-clockwise
  bool from_inside;

  PlanWall wall(double low_rad, double high_rad, double thickness_m, bool assumed) const {
    const auto way = [&](double turn) {
      return Vector(std::cos(from_rad + turn), std::sin(from_rad + turn));
    };
    const double middle_rad = (low_rad + high_rad) / 2;
    return {centre + radius * way(low_rad),
            centre + radius * way(high_rad),
            way(middle_rad) * (from_inside ? -1.0 : 1.0),
            thickness_m,
            assumed,
            bulge_of(high_rad - low_rad)};
  }
};

CurvedStretch curved_stretch(const RoomEdge& edge) {
  const BulgeArc arc = bulge_arc(edge.from, edge.to, edge.bulge);
  const bool inside = arc.turn_rad > 0;
  return {arc.centre, arc.radius, inside ? arc.from_rad : arc.from_rad + arc.turn_rad,
          std::abs(arc.turn_rad), inside};
}

void add_curved_walls(const std::vector<CurvedStretch>& stretches, std::vector<PlanWall>& walls) {
  constexpr double kConcentricM = 0.10, kWhole = 2 * std::numbers::pi;
  for (const CurvedStretch& one : stretches) {
    std::vector<std::pair<double, double>> paired;
    for (const CurvedStretch& other : stretches) {
      const double thickness = (other.radius - one.radius) * (one.from_inside ? 1.0 : -1.0);
      if (other.from_inside == one.from_inside || thickness < -0.04 || thickness > kThickestWallM ||
          (other.centre - one.centre).norm() > kConcentricM) {
        continue;
      }
      const double begin = turn_between(one.from_rad, other.from_rad);
      for (const double from : {begin, begin - kWhole}) {
        const double low = std::max(0.0, from),
                     high = std::min(one.span_rad, from + other.span_rad);
        if ((high - low) * one.radius < kLeastOverlapM) continue;
        paired.emplace_back(low, high);
        if (one.from_inside) walls.push_back(one.wall(low, high, std::max(0.0, thickness), false));
      }
    }
    for (const auto& [low, high] : rest_of(paired, one.span_rad)) {
      if ((high - low) * one.radius > 0.02) walls.push_back(one.wall(low, high, kAssumedM, true));
    }
  }
}

struct Stretch {
  Vector from, to, normal;
  double offset() const { return normal.dot(from); }
};

}  // namespace

std::vector<PlanWall> walls_of(const FloorPlan& plan) {
  std::vector<Stretch> stretches;
  std::vector<CurvedStretch> curved;
  for (const PlanRoom& room : plan.rooms) {
    for (const RoomEdge& edge : room.edges()) {
      if (edge.kind != EdgeKind::wall) continue;
      if (edge.bulge != 0.0) {
        curved.push_back(curved_stretch(edge));
        continue;
      }
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
    for (const auto& [low, high] : rest_of(paired, length)) {
      if (high - low > 0.02) {
        walls.push_back({one.from + way * low, one.from + way * high, one.normal, kAssumedM, true});
      }
    }
  }
  add_curved_walls(curved, walls);
  return walls;
}

}  // namespace marco::plan
