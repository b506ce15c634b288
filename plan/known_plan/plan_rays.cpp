#include "plan/known_plan/plan_rays.hpp"

#include <algorithm>
#include <cmath>

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

double cross(const Vector& a, const Vector& b) { return a.x() * b.y() - a.y() * b.x(); }

double distance_m(const KnownPlan::Line& line, const Vector& point) {
  const Vector along = line.to - line.from;
  const double part = along.dot(point - line.from) / along.squaredNorm();
  return (line.from + std::clamp(part, 0.0, 1.0) * along - point).norm();
}

}  // namespace

PlanRays::PlanRays(const std::vector<KnownPlan::Line>& lines) : lines_(lines) {
  Vector high = lines.front().from;
  low_ = high;
  for (const KnownPlan::Line& line : lines) {
    low_ = low_.cwiseMin(line.from).cwiseMin(line.to);
    high = high.cwiseMax(line.from).cwiseMax(line.to);
  }
  low_ -= Vector(kCellM, kCellM);
  width_ = static_cast<int>((high.x() - low_.x()) / kCellM) + 2;
  height_ = static_cast<int>((high.y() - low_.y()) / kCellM) + 2;
  cells_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const KnownPlan::Line& line = lines[i];
    const int steps = std::max(1, static_cast<int>(std::ceil(line.length_m() / (kCellM / 2))));
    for (int step = 0; step <= steps; ++step) {
      const Vector at = (line.from + (line.to - line.from) * step / steps - low_) / kCellM;
      // With its neighbours, for steps that cut a corner.
      for (int y = static_cast<int>(at.y()) - 1; y <= static_cast<int>(at.y()) + 1; ++y) {
        for (int x = static_cast<int>(at.x()) - 1; x <= static_cast<int>(at.x()) + 1; ++x) {
          if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
          auto& list = cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                              static_cast<std::size_t>(x)];
          if (list.empty() || list.back() != static_cast<int>(i)) {
            list.push_back(static_cast<int>(i));
          }
        }
      }
    }
  }
}

const std::vector<int>* PlanRays::cell(int x, int y) const {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return nullptr;
  return &cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(x)];
}

std::optional<PlanRays::Hit> PlanRays::cast(const Vector& from,
                                            const Vector& way,
                                            double reach_m) const {
  // Lines lie in the cells about them, too: steps of a cell pass none by.
  std::optional<Hit> nearest;
  for (double gone = 0.0; gone <= reach_m; gone += kCellM) {
    if (nearest && nearest->range_m < gone - kCellM) break;
    const Vector at = (from + way * gone - low_) / kCellM;
    const auto* list =
        cell(static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())));
    if (list == nullptr) continue;
    for (const int i : *list) {
      const KnownPlan::Line& line = lines_[static_cast<std::size_t>(i)];
      const Vector along = line.to - line.from;
      const double turn = cross(way, along);
      if (std::abs(turn) < 1e-12) continue;
      const double range = cross(line.from - from, along) / turn;
      const double part = cross(line.from - from, way) / turn;
      if (range > 0 && range <= reach_m && part >= -1e-9 && part <= 1 + 1e-9 &&
          (!nearest || range < nearest->range_m)) {
        nearest = Hit{i, range};
      }
    }
  }
  return nearest;
}

bool PlanRays::is_near(const Vector& point, double radius_m) const {
  const Vector at = (point - low_) / kCellM;
  const auto* list =
      cell(static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())));
  return list != nullptr && std::any_of(list->begin(), list->end(), [&](int i) {
           return distance_m(lines_[static_cast<std::size_t>(i)], point) < radius_m;
         });
}

}  // namespace marco::plan
