#pragma once

#include "slam/doctor/doctor.hpp"

namespace marco::slam {

/// Where one pass contradicts another, over a stretch of path: fills the figures, adds reasons, and
/// looks for the pose that would lay both on each other.
void examine_visits(const MapEvidence& map, Diagnosis& diagnosis);

}  // namespace marco::slam
