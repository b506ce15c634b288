#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "plan/known_plan/known_plan.hpp"

namespace marco::plan {

/// Casts rays against the lines of a plan, which lie in a raster. Const: safe from several threads.
class PlanRays {
 public:
  /// @param lines  at least one; outlive the object
  explicit PlanRays(const std::vector<KnownPlan::Line>& lines);

  struct Hit {
    int line = 0;
    double range_m = 0.0;
  };
  /// @param way  unit
  std::optional<Hit> cast(const Eigen::Vector2d& from,
                          const Eigen::Vector2d& way,
                          double reach_m) const;
  /// Whether any line passes within `radius_m`, at most the cell's size.
  bool is_near(const Eigen::Vector2d& point, double radius_m) const;

  static constexpr double kCellM = 0.5;  ///< of the raster that finds lines: speed alone

 private:
  const std::vector<int>* cell(int x, int y) const;

  const std::vector<KnownPlan::Line>& lines_;
  Eigen::Vector2d low_ = {0, 0};
  int width_ = 0, height_ = 0;
  std::vector<std::vector<int>> cells_;
};

}  // namespace marco::plan
