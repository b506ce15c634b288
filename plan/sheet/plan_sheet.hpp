#pragma once

#include <Eigen/Geometry>
#include <string>

#include "plan/floor_plan.hpp"
#include "plan/sheet/sheet.hpp"

namespace marco::plan {

struct SheetWish {
  int scale = 0;      ///< 1:scale; 0: chosen, see choose_layout()
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
