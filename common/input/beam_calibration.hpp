#pragma once

#include <string>

#include "common/laser_scan.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco {

/// What a laser's beams are found to be, over what its messages say. By default as said.
struct BeamCalibration {
  std::string channel;          ///< of the laser
  double bearing_scale = 1.0;   ///< true bearing over the said one, both from the sensor's x axis
  double range_offset_m = 0.0;  ///< true range less the measured one

  template <class Visitor>
  void visit(Visitor& v) {
    v("channel", channel);
    v("bearing_scale", bearing_scale, Limits{0.5, 2.0});
    v("range_offset_m", range_offset_m, Limits{-1.0, 1.0});
  }
  bool operator==(const BeamCalibration&) const = default;

  /// Puts bearings and ranges right. What is no return stays none: 0 and less, and ranges from
  /// `range_max_m` on. A range that the offset takes below 0 becomes none.
  void correct(LaserScan& scan, double range_max_m) const;
};

}  // namespace marco
