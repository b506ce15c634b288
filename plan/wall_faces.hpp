#pragma once

#include <vector>

#include "plan/floor_plan.hpp"
#include "plan/surfels.hpp"

namespace marco::plan {

/// Finds the faces, largest first: a peak of the Hough transform of the surfels, then least squares
/// over all their points, grown along the line while it is seen. @param aligned  whether the
/// frame's axes are main directions: a face that is parallel to one within 3 sigma, takes it.
/// @param taken  surfels of curved faces, which are left out; empty: none
std::vector<WallFace> find_faces(const std::vector<PlanSurfel>& surfels,
                                 bool aligned,
                                 std::vector<bool> taken = {});

}  // namespace marco::plan
