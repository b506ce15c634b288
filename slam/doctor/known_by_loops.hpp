#pragma once

#include <limits>

#include "slam/doctor/doctor.hpp"

namespace marco::slam {

/// How well loops know how the ends of a stretch lie to each other; infinite: not at all.
struct KnownByLoops {
  double sigma_m = std::numeric_limits<double>::infinity();
  double sigma_rad = std::numeric_limits<double>::infinity();
};

/// What is known of the stretch between both times round its own steps. Cost: a factorization of
/// the graph.
KnownByLoops known_by_loops(const MapEvidence& map, Utime from, Utime to);

}  // namespace marco::slam
