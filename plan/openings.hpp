#pragma once

#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/free_space.hpp"

namespace marco::plan {

/// Gaps between jambs that beams went through, 0.5 to 3 m wide: both jambs are ends of faces on one
/// line, or (up to 1.3 m) the second is a crossing wall. The space on both sides is wider than the
/// gap, as far as it was seen, so that a corridor's bend is none. Whether it joins two rooms, the
/// rooms decide.
std::vector<PlanOpening> find_openings(const FloorPlan& plan, const FreeSpace& space);

/// Takes door leaves out of the faces: as long as an opening is wide, hinged at a jamb, and free
/// beyond the tip. A face that continues beyond the jamb is cut there; a wall that does so is no
/// leaf, as it is thicker. The openings keep them.
void take_leaves(std::vector<WallFace>& faces,
                 std::vector<PlanOpening>& openings,
                 const FreeSpace& space);

}  // namespace marco::plan
