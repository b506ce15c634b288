#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "mapping3d/surfels.hpp"

namespace marco::mapping3d {

/// Pairs (a, b), a < b, of surfel sets that saw the same surfaces: surfels in the same cubes of a
/// grid that face the same way. Of many partners only the strongest are kept, so that the pairs
/// grow with the number of sets.
/// @param sets  in one frame, right to a fraction of a metre
/// @param min_shared  surfels that two sets must share
/// Cost: linear in the surfels, and quadratic in the number of sets that see one cube.
std::vector<std::pair<std::size_t, std::size_t>> find_overlaps(
    const std::vector<const std::vector<Surfel>*>& sets, std::size_t min_shared);

}  // namespace marco::mapping3d
