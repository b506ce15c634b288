#pragma once

#include <optional>

#include "slam/calibration/beam_fit.hpp"
#include "slam/calibration/self_calibration.hpp"
#include "tools/map/map_job.hpp"

namespace marco {

/// What a drive says of its laser's beams, over what its map was made with.
struct BeamSearch {
  BeamCalibration in_use;
  slam::BeamFit found;

  bool is_off() const;
  /// What the next map is to be made with: what is off, corrected.
  BeamCalibration corrected() const;
  /// As `beams.bearing_scale` and `beams.range_offset_m`. @param better  whether the map made with
  /// corrected() was better
  void add_to(slam::SelfCalibration& calibration, bool better) const;
};

/// @returns nothing of several lasers, for a map does not tell whose points it is made of; and
/// nothing where too few walls were seen from two places.
std::optional<BeamSearch> search_beams(const MapJob& job);

/// The floor or the ceiling in view of the laser, which is fixed to the robot. @returns nothing of
/// several lasers
std::optional<FloorLine> search_floor(const MapJob& job);

}  // namespace marco
