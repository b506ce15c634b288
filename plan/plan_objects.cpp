#include "plan/plan_steps.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "plan/curved_faces.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;
using Points = std::vector<Vector>;

// Islands: cells that are no room, and that one room alone surrounds. @returns an island of each
// cell, -1: none
std::vector<int> islands_of(const FreeSpace& space, const RoomRaster& raster) {
  const int width = space.width(), cells = width * space.height();
  std::vector<int> island(static_cast<std::size_t>(cells), -1);
  std::vector<char> known(static_cast<std::size_t>(cells), 0);
  int count = 0;
  for (int start = 0; start < cells; ++start) {
    if (known[static_cast<std::size_t>(start)] || space.is_free(start)) continue;
    std::vector<int> members{start};
    known[static_cast<std::size_t>(start)] = 1;
    std::set<int> rooms;
    bool closed = true;
    for (std::size_t next = 0; next < members.size(); ++next) {
      const int x = members[next] % width, y = members[next] / width;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= width || y + dy >= space.height()) {
            closed = false;
            continue;
          }
          const int cell = (y + dy) * width + x + dx;
          if (space.is_free(cell)) {
            rooms.insert(raster.room[static_cast<std::size_t>(cell)]);
          } else if (!known[static_cast<std::size_t>(cell)]) {
            known[static_cast<std::size_t>(cell)] = 1;
            members.push_back(cell);
          }
        }
      }
    }
    if (!closed || rooms.size() != 1 || *rooms.begin() < 0) continue;
    for (const int cell : members) island[static_cast<std::size_t>(cell)] = count;
    ++count;
  }
  return island;
}

Points hull_of(Points points) {
  std::sort(points.begin(), points.end(), [](const Vector& a, const Vector& b) {
    return std::tie(a.x(), a.y()) < std::tie(b.x(), b.y());
  });
  Points hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t base = hull.size();
    for (const Vector& point : points) {
      while (hull.size() >= base + 2) {
        const Vector a = hull.back() - hull[hull.size() - 2], b = point - hull.back();
        if (a.x() * b.y() - a.y() * b.x() > 0) break;
        hull.pop_back();
      }
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// Algebraic (Kasa 1976); small objects are seen over most of their turn.
void fit_roughly(const Points& points, PlanObject& object) {
  Eigen::MatrixX3d rows(static_cast<Eigen::Index>(points.size()), 3);
  Eigen::VectorXd squares(static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vector off = points[i] - points[0];
    rows.row(row) << 2 * off.x(), 2 * off.y(), 1;
    squares(row) = off.squaredNorm();
  }
  const Eigen::Vector3d found = rows.colPivHouseholderQr().solve(squares);
  object.centre = points[0] + found.head<2>();
  object.radius_m = std::sqrt(std::max(0.0, found.z() + found.head<2>().squaredNorm()));
  double sum = 0;
  std::set<int> turns;
  for (const Vector& point : points) {
    const Vector off = point - object.centre;
    sum += std::pow(off.norm() - object.radius_m, 2);
    turns.insert(static_cast<int>(std::floor(std::atan2(off.y(), off.x()) / deg_to_rad(30))));
  }
  object.round = points.size() >= 12 && turns.size() >= 5 && object.radius_m > 0.04 &&
                 object.radius_m < 0.7 &&
                 std::sqrt(sum / static_cast<double>(points.size())) < 0.02;
}

}  // namespace

void measure_round(const std::vector<slam::Keyframe>& keyframes,
                   const Pose2& plan_from_map,
                   std::vector<PlanObject>& objects) {
  constexpr double kNearM = 0.10;  // of the rough circle: the object's hits
  for (PlanObject& object : objects) {
    if (!object.round) continue;
    slam::FittedCircle start;
    start.centre_m = object.centre;
    start.radius_m = object.radius_m;
    const auto circle = fit_to_hits(keyframes, plan_from_map, start, kNearM);
    if (!circle) continue;
    object.centre = circle->centre_m;
    object.radius_m = circle->radius_m;
    object.radius_sigma_m = std::sqrt(circle->covariance(2, 2));
  }
}

std::vector<PlanObject> find_objects(const FreeSpace& space,
                                     const RoomRaster& raster,
                                     const std::vector<PlanSurfel>& surfels) {
  const std::vector<int> island = islands_of(space, raster);
  std::map<int, Points> hits;
  for (const PlanSurfel& surfel : surfels) {
    const int cell = space.cell_of(surfel.mean());
    if (cell < 0 || island[static_cast<std::size_t>(cell)] < 0 || surfel.keyframes < 2) continue;
    Points& of_it = hits[island[static_cast<std::size_t>(cell)]];
    of_it.push_back(surfel.mean());
  }
  std::vector<PlanObject> objects;
  for (const auto& [which, points] : hits) {
    if (points.size() < 4) continue;
    PlanObject object;
    object.outline = hull_of(points);
    Vector low = points[0], high = points[0];
    for (const Vector& point : points) low = low.cwiseMin(point), high = high.cwiseMax(point);
    if (object.outline.size() < 3 || (high - low).maxCoeff() > kLargestObjectM) continue;
    fit_roughly(points, object);
    objects.push_back(std::move(object));
  }
  return objects;
}

}  // namespace marco::plan
