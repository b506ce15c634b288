#pragma once

#include <vector>

#include "landmarks/point_filter.hpp"

namespace marco::slam {

/// What became of one sighting.
struct SightingMatch {
  static constexpr int kNew = -1;      ///< near no landmark: it may be a new one
  static constexpr int kUnclear = -2;  ///< could be one of the map's, or of two: not used
  int landmark = kNew;
};

/// Data association: the largest set of pairings of a scan's sightings with landmarks, one to one,
/// that the filter's joint uncertainty allows (joint_compatibility). A pairing stands only where no
/// other landmark explains the sighting about as well; a sighting that is unpaired near a free
/// landmark is unclear, never new. @returns one match per sighting.
std::vector<SightingMatch> associate_sightings(const PointFilter& filter,
                                               const std::vector<Sighting>& sightings,
                                               const SightingNoise& noise,
                                               double gate_probability);

}  // namespace marco::slam
