#include "common/input/beam_calibration.hpp"

#include <algorithm>

namespace marco {

void BeamCalibration::correct(LaserScan& scan, double range_max_m) const {
  scan.first_bearing_rad *= bearing_scale;
  scan.bearing_step_rad *= bearing_scale;
  for (float& bearing_rad : scan.bearings_rad) bearing_rad *= static_cast<float>(bearing_scale);
  if (range_offset_m == 0.0) return;
  const float no_return_m = static_cast<float>(std::min(range_max_m, kFarthestReturnM));
  for (float& range_m : scan.ranges_m) {
    if (!(range_m > 0.0F && range_m < no_return_m)) continue;
    range_m = std::max(0.0F, range_m + static_cast<float>(range_offset_m));
  }
}

}  // namespace marco
