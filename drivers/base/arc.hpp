#pragma once

#include "common/pose2.hpp"

namespace marco::drivers {

/// A step along an arc of constant curvature, by its chord: wheels at constant speeds.
inline Pose2 along_arc(double way_m, double turn_rad) {
  return {way_m * std::cos(turn_rad / 2.0), way_m * std::sin(turn_rad / 2.0), turn_rad};
}

}  // namespace marco::drivers
