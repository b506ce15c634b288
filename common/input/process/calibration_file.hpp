#pragma once

#include "common/input/pantilt_correction.hpp"
#include "common/input/sensor_calibration.hpp"

namespace marco {

/// calibration.toml: what `marco calibrate` writes, and `--calibration` reads.
struct CalibrationFile : SensorCalibration {
  PanTiltCorrection pantilt;

  template <class Visitor>
  void visit(Visitor& v) {
    SensorCalibration::visit(v);
    v("pantilt", pantilt);
  }
};

}  // namespace marco
