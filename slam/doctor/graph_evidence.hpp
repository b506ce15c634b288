#pragma once

#include "slam/doctor/doctor.hpp"

namespace marco::slam {

/// What loops and joints of the pose graph say: fills their figures and adds their reasons.
/// @param diagnosis  knows whether there is an odometry
void examine_graph(const MapEvidence& map, Diagnosis& diagnosis);

}  // namespace marco::slam
