#pragma once

#include "tools/model/cloud_scan.hpp"

namespace marco {

/// Finds the places of scans without a pose by what they see in common with the others: walls from
/// above, searched all around by branch and bound (CorrelativeMatcher) in eight headings; of these
/// candidates the one at which most surfaces lie on each other in space is taken, if it is clearly
/// better than the others. The scanners stood upright. Scans with poses stay; without any the first
/// scan is the world. The strongest match is placed first, and helps to find the next one.
/// @returns the scans that were not found; they keep has_pose = false.
std::vector<std::size_t> find_start_poses(std::vector<CloudScan>& scans);

}  // namespace marco
