#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace marco {

/// No laser that maps buildings sees farther.
inline constexpr double kFarthestLaserM = 80.0;

/// Finds the range that a laser reports when nothing came back: the pile at the top of all ranges.
/// Walls do not pile up there, as the robot moves and the beams are slanted. A pile may be spread,
/// by several codes close together (81.83, 81.91) or by noise that was added to it. Not
/// thread-safe.
class NoReturnRange {
 public:
  void add(const std::vector<float>& ranges_m);
  /// This range [m] and more is no return; `otherwise_m` where there is no pile.
  double range_m(double otherwise_m) const;

 private:
  // Bins of half a per cent, from 0.1 m to a kilometre.
  static constexpr double kFirstM = 0.1, kBinsPerFold = 200.0;
  static constexpr int kBins = 1843;
  std::array<int64_t, kBins> counts_{};
};

}  // namespace marco
