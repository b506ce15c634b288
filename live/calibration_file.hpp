#pragma once

#include <string>

#include "common/input/pantilt_correction.hpp"
#include "common/input/sensor_calibration.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"

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

/// Adds `--calibration FILE`, which stays in `path`.
inline process::Option add_calibration_argument(process::CommandLine& app, std::string& path) {
  return app
      .add_option("--calibration", path,
                  "calibration.toml of an earlier `marco calibrate`: corrects odometry, gyroscope "
                  "and the sensors' mounts")
      .existing_file();
}

/// @param path "" for a robot that is as its SENSOR_INFO says
inline CalibrationFile load_calibration(const std::string& path) {
  return path.empty() ? CalibrationFile{} : process::load_options<CalibrationFile>(path);
}

}  // namespace marco
