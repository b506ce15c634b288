#pragma once

#include "common/laser_scan.hpp"
#include "python/arrays.hpp"

namespace marco::python {

/// A scan as Python has it.
struct Scan {
  double time_s = 0.0;
  std::string channel;
  pybind11::array_t<float> ranges_m;       ///< NaN: no return
  pybind11::array_t<double> bearings_rad;  ///< counter-clockwise from ahead, laser frame

  /// Nx2 [m], laser frame, the returns alone.
  pybind11::array_t<double> points() const;
};

/// @param range_max_m  this range and more is no return
Scan to_scan(const LaserScan& scan, double range_min_m, double range_max_m);

}  // namespace marco::python
