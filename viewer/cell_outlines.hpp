#pragma once

#include "viewer/cell_areas.hpp"

namespace marco::viewer {

/// A closed line, the last point joined to the first. In cells: cell (x, y) reaches from its corner
/// (x, y) to (x + 1, y + 1).
using Outline = std::vector<Eigen::Vector2d>;

/// The outlines of a mask's areas, the area at the left of the way along them: round an area
/// counter-clockwise, round a hole in it clockwise. Smoothed, so that the steps of a slanting wall
/// become a slope while corners between straight stretches of four cells stay, and with as few
/// points as keep within 0.3 cells.
std::vector<Outline> smooth_outlines(const CellMask& mask);

}  // namespace marco::viewer
