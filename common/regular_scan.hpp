#pragma once

#include "common/laser_scan.hpp"

namespace marco {

/// A scan whose beams have bearings of their own, on regular bearings: a full turn from -180 deg in
/// steps of 0.25, 0.5, 1 or 2 deg, whichever its beams fill best. Each beam goes to the nearest
/// bearing (of two the nearer in angle); bearings without a beam get `no_return_m`, and so do
/// ranges that are 0, not finite or beyond it. Scans that are regular already come back as they
/// are.
LaserScan make_regular(const LaserScan& scan, float no_return_m);

}  // namespace marco
