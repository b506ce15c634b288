#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "plan/drawing/drawing.hpp"

namespace marco::plan {

/// How somebody wants a drawing to be read.
struct PlanWish {
  std::string layers;  ///< names of those with walls, separated by commas; "" = by their names
  /// One unit of the drawing: mm, cm, m, in, ft, metres as a number, or 1:100, a scale on paper; ""
  /// = what the file says.
  std::string unit;
};

/// The walls of a drawing in metres, in the drawing's frame: x to the right, y up.
struct KnownPlan {
  struct Line {
    Eigen::Vector2d from = {0, 0};
    Eigen::Vector2d to = {0, 0};
    int shape = 0;  ///< lines drawn as one share it
    bool curved = false;

    double length_m() const { return (to - from).norm(); }
  };
  std::vector<Line> lines;
  double unit_m = 1.0;
  std::vector<std::string> taken, passed_over;  ///< layers

  Eigen::Vector2d low_m() const;
  Eigen::Vector2d high_m() const;
};

/// Which layers hold walls. By name: those that say wall, column and the like in one of seven
/// languages, where there are any; else all but those that say door, dimension, furniture and the
/// like.
std::vector<bool> choose_layers(const std::vector<std::string>& layers, const std::string& wanted);

/// @throws std::invalid_argument, to be put behind the file's name: for a layer that is not there,
/// a scale that is neither said nor given, no walls, or walls that reach over less than 1 m or more
/// than 2 km.
KnownPlan known_plan_of(const Drawing& drawing, const PlanWish& wish);

}  // namespace marco::plan
