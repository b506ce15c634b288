#include "simulator/device_lasers.hpp"

#include "lcm_tools/base/check.hpp"

namespace marco::sim {
namespace {

// URG-04LX: steps 44 to 725 of 1024, 384 ahead, 600 turns a minute.
LaserOptions hokuyo() {
  constexpr double kStepDeg = 360.0 / 1024.0;
  LaserOptions laser;
  laser.beams = 725 - 44 + 1;
  laser.first_bearing_deg = (44 - 384) * kStepDeg;
  laser.step_deg = kStepDeg;
  laser.scans_per_s = 10.0;
  laser.interlaced_turns = 1;
  laser.scan_duration_s = 0.1 * (725 - 44) / 1024.0;
  laser.range_min_m = 0.02;
  laser.range_max_m = 5.6;
  laser.no_return_m = 0.0;
  return laser;
}

// A1, express scan: 5.5 turns a second, clockwise from ahead, a sample each 254 us.
LaserOptions rplidar() {
  constexpr double kTurnsPerS = 5.5, kSampleS = 254e-6;
  LaserOptions laser;
  laser.beams = 715;  // the last whole sample of a turn
  laser.first_bearing_deg = 0.0;
  laser.step_deg = -360.0 * kTurnsPerS * kSampleS;
  laser.scans_per_s = kTurnsPerS;
  laser.interlaced_turns = 1;
  laser.scan_duration_s = (laser.beams - 1) * kSampleS;
  laser.range_min_m = 0.15;
  laser.range_max_m = 12.0;
  laser.no_return_m = 0.0;
  laser.range_sigma_m = 0.02;
  return laser;
}

// LD19: ten turns a second, clockwise from ahead, 4500 samples a second.
LaserOptions ld19() {
  LaserOptions laser;
  laser.beams = 450;
  laser.first_bearing_deg = 0.0;
  laser.step_deg = -0.8;
  laser.scans_per_s = 10.0;
  laser.interlaced_turns = 1;
  laser.scan_duration_s = 449.0 / 4500.0;
  laser.range_min_m = 0.02;
  laser.range_max_m = 12.0;
  laser.no_return_m = 0.0;
  return laser;
}

// X4: seven turns a second, clockwise from ahead, 5000 samples a second.
LaserOptions ydlidar_x4() {
  constexpr double kTurnsPerS = 7.0, kSamplesPerS = 5000.0;
  LaserOptions laser;
  laser.beams = 714;  // the last whole sample of a turn
  laser.first_bearing_deg = 0.0;
  laser.step_deg = -360.0 * kTurnsPerS / kSamplesPerS;
  laser.scans_per_s = kTurnsPerS;
  laser.interlaced_turns = 1;
  laser.scan_duration_s = (laser.beams - 1) / kSamplesPerS;
  laser.range_min_m = 0.12;
  laser.range_max_m = 10.0;
  laser.no_return_m = 0.0;
  laser.range_sigma_m = 0.02;
  return laser;
}

// TiM561: 15 turns a second, 270 deg in steps of a third.
LaserOptions tim561() {
  LaserOptions laser;
  laser.beams = 811;
  laser.first_bearing_deg = -135.0;
  laser.step_deg = 0.3333;
  laser.scans_per_s = 15.0;
  laser.interlaced_turns = 1;
  laser.scan_duration_s = 810 * 0.3333 / 360.0 / 15.0;
  laser.range_min_m = 0.05;
  laser.range_max_m = 10.0;
  laser.no_return_m = 0.0;
  laser.range_sigma_m = 0.02;
  return laser;
}

// RS4: each fourth of 529 beams, 0.36 deg apart, clockwise; a turn takes 40 ms.
LaserOptions leuze() {
  LaserOptions laser;
  laser.beams = 133;
  laser.first_bearing_deg = 264 * 0.36;
  laser.step_deg = -4 * 0.36;
  laser.scans_per_s = 25.0;
  laser.interlaced_turns = 1;
  laser.scan_duration_s = 0.040 * 528 * 0.36 / 360.0;
  laser.range_min_m = 0.1;
  laser.range_max_m = 64.0;
  laser.no_return_m = 65.0;
  laser.range_sigma_m = 0.02;
  laser.quantum_m = 0.002;
  return laser;
}

}  // namespace

LaserOptions device_laser(const std::string& device) {
  if (device == "hokuyo") return hokuyo();
  if (device == "rplidar") return rplidar();
  if (device == "ld19") return ld19();
  if (device == "ydlidar_x4") return ydlidar_x4();
  if (device == "tim561") return tim561();
  if (device == "leuze") return leuze();
  require(
      device == "sick",
      "laser '" + device + "': expected sick, hokuyo, rplidar, ld19, ydlidar_x4, tim561 or leuze");
  return {};
}

}  // namespace marco::sim
