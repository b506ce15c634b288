#pragma once

#include <optional>
#include <vector>

#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// A value is believed where it differs by this many standard deviations.
inline constexpr double kSure = 3.0;

/// A number, and its standard deviation.
struct Estimate {
  double value = 0.0;
  double sigma = 0.0;

  /// Whether it is off by more than chance explains.
  bool differs_from(double assumed) const;
};

/// What a laser's beams really are, over what its messages say.
struct BeamFit {
  Estimate bearing_scale{1.0};  ///< true bearing over the said one, both from the sensor's x axis
  Estimate range_offset_m{};    ///< true range less the measured one
};

/// Finds bearings that are too wide or too narrow, and ranges that are too short or too long, by
/// walls that two keyframes saw from different places and under different bearings: with wrong
/// beams no rigid motion lays one on the other. Least squares over a motion of each pair and the
/// two values, point to line, robust (Lorentzian). Ranges that are wrong by a factor cannot be
/// seen: they give the same map, smaller. A pure function; 50 ms for any map.
///
/// The standard deviations hold what neighbouring pairs get wrong alike (sandwich estimator over
/// blocks of them), and what real lasers' ranges do at grazing incidence.
/// @param keys  all of one laser
/// @param least_bearing_rad  of its beams as said: bearings are counted up from there
/// @returns nothing where too few pairs of keyframes see the same walls.
std::optional<BeamFit> fit_beams(const std::vector<Keyframe>& keys, double least_bearing_rad);

/// How sharp a map is: cells of 5 cm that hold 90 % of its keyframes' points, the fullest first. Of
/// two paths for the same scans the better one needs fewer; a doubled room needs half as many
/// again.
std::size_t cells_of_walls(const std::vector<Keyframe>& keys);

}  // namespace marco::slam
