#pragma once

#include "common/samples.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco {

/// What a calibration adds to the SENSOR_INFO of a pan-tilt and its laser. Height and pan zero are
/// not included: scans cannot observe them.
struct PanTiltCorrection {
  double axis_x_m = 0.0;   ///< tilt axis ahead of the pan axis
  double axis_y_m = 0.0;   ///< laser left of the pan axis
  double lever_x_m = 0.0;  ///< laser ahead of the tilt axis, at tilt 0
  double lever_z_m = 0.0;  ///< laser above the tilt axis, at tilt 0
  double roll_deg = 0.0;   ///< of the laser on the tilted plate
  double pitch_deg = 0.0;  ///< of the laser, > 0 looks down: the tilt's zero
  double yaw_deg = 0.0;    ///< of the laser: the bearings' zero
  double late_s = 0.0;     ///< stamps of the pan-tilt's angles are so much later than the angles

  template <class Visitor>
  void visit(Visitor& v) {
    v("axis_x_m", axis_x_m);
    v("axis_y_m", axis_y_m);
    v("lever_x_m", lever_x_m);
    v("lever_z_m", lever_z_m);
    v("roll_deg", roll_deg);
    v("pitch_deg", pitch_deg);
    v("yaw_deg", yaw_deg);
    v("late_s", late_s, Limits{-10.0, 10.0});
  }

  SensorInfo base(SensorInfo as_said) const;
  SensorInfo sensor(SensorInfo as_said) const;
};

}  // namespace marco
