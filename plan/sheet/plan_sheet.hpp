#pragma once

#include <Eigen/Geometry>
#include <string>

#include "plan/floor_plan.hpp"
#include "plan/sheet/sheet.hpp"

namespace marco::plan {

struct SheetWish {
  /// 1:scale; 0: 1:100 on up to A2, as a floor plan mostly comes, beyond that the largest of 1:200,
  /// 1:500, 1:1000 and 1:2000 that A2 takes; on a given paper 1:50, too.
  int scale = 0;
  std::string paper;  ///< A4 .. A0; "": the smallest that fits
  std::string title;
  std::string source;  ///< what was mapped, and when
};

/// What the rooms take, in the plan's frame; empty without a room.
Eigen::AlignedBox2d extent_of(const FloorPlan& plan);

/// Draws the plan to scale, with dimensions, areas, title block, scale bar and legend.
/// @throws std::invalid_argument when the paper is unknown or too small for the scale: it says
/// which scale fits.
Sheet draw_sheet(const FloorPlan& plan, const SheetWish& wish);

}  // namespace marco::plan
