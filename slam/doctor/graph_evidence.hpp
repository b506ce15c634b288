#pragma once

#include <limits>

#include "slam/doctor/doctor.hpp"

namespace marco::slam {

/// What loops and joints of the pose graph say: fills their figures and adds their reasons.
/// @param diagnosis  knows whether there is an odometry
void examine_graph(const MapEvidence& map, Diagnosis& diagnosis);

/// How well loops know how the ends of a stretch lie to each other; infinite: not at all.
struct KnownByLoops {
  double sigma_m = std::numeric_limits<double>::infinity();
  double sigma_rad = std::numeric_limits<double>::infinity();
};

/// What is known of the stretch between both times round its own steps. Cost: a factorization of
/// the graph.
KnownByLoops known_by_loops(const MapEvidence& map, Utime from, Utime to);

}  // namespace marco::slam
