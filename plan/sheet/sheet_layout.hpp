#pragma once

#include <Eigen/Core>

#include "plan/sheet/plan_sheet.hpp"

namespace marco::plan {

inline constexpr double kMarginMm = 10.0;      ///< of the paper, which printers leave white
inline constexpr double kDimensionsMm = 16.0;  ///< left of the plan and above it
inline constexpr double kTitleMm = 34.0;       ///< height of the block below

struct Paper {
  const char* name;
  double width_mm, height_mm;
};

/// A sheet's paper and scale, and the room that they leave for the plan [mm].
struct SheetLayout {
  Paper paper;
  bool upright = false;
  int scale = 0;
  double width() const { return upright ? paper.height_mm : paper.width_mm; }
  double height() const { return upright ? paper.width_mm : paper.height_mm; }
  double free_width() const { return width() - 2 * kMarginMm - 2 * kDimensionsMm; }
  double free_height() const { return height() - 2 * kMarginMm - 2 * kDimensionsMm - kTitleMm; }
};

/// Without a wish 1:100 on up to A2, as a floor plan mostly comes; beyond that the largest of
/// 1:200, 1:500, 1:1000 and 1:2000 that A2 takes. On a given paper 1:50, too.
/// @throws std::invalid_argument for paper that is not known, or where nothing fits, with what
/// would.
SheetLayout choose_layout(const SheetWish& wish, const Eigen::Vector2d& size_m);

}  // namespace marco::plan
