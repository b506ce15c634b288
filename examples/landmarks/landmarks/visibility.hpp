#pragma once

#include <array>
#include <limits>
#include <vector>

#include "landmarks/sighting.hpp"

namespace marco::slam {

/// How likely a landmark is seen at a range, and within which bearings: learned from what is seen
/// and missed, so that it holds for any sensor. Not thread-safe.
class Visibility {
 public:
  /// Bearings and ranges that the sensor reaches.
  void add_scan(const std::vector<Sighting>& sightings);
  /// A landmark of the map that should be at this range was seen, or not.
  void vote(double range_m, bool seen);

  /// @returns 0 beyond the reach.
  double probability(double range_m, double bearing_rad) const;

 private:
  struct Votes {
    double seen = 0.0, all = 0.0;
  };
  static std::size_t ring(double range_m);

  static constexpr int kRingsPerOctave = 3;   // of range: 26 % from ring to ring
  static constexpr double kFirstRingM = 0.1;  // nearer is the sensor itself
  std::array<Votes, 40> rings_{};
  double largest_m_ = 0.0;
  double least_rad_ = std::numeric_limits<double>::infinity();
  double most_rad_ = -std::numeric_limits<double>::infinity();
};

}  // namespace marco::slam
