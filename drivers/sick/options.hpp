#pragma once

#include <cmath>
#include <string>

#include "drivers/sick/codec.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::sick {

inline constexpr double kTurnS = 1.0 / 75.0;  ///< of the mirror

struct SickOptions {
  static constexpr const char* kName = "sick";
  static constexpr const char* kDefaultDevice = "/dev/ttyUSB0";

  int baud = 38400;             ///< to measure at: 9600, 19200, 38400 or 500000 (RS-422)
  int angle_deg = 180;          ///< 180 or 100
  double resolution_deg = 0.5;  ///< 1, 0.5 or (of 100 degrees) 0.25
  std::string unit = "mm";      ///< of the values: "mm" or "cm"
  int range_m = 32;             ///< mm: 8, 16, 32 (thesis B, app. B); cm: 80, 160, 320
  bool interlaced = false;      ///< each turn of the mirror as a scan of its own, 75 a second
  std::string password = "SICK_LMS";
  double range_min_m = 0.05;
  double range_sigma_m = 0.015;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{9600, 500000});
    v("angle_deg", angle_deg, Limits{100, 180});
    v("resolution_deg", resolution_deg, Limits{0.25, 1.0});
    v("unit", unit);
    v("range_m", range_m, Limits{8, 320});
    v("interlaced", interlaced);
    v("password", password);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }

  int resolution_cdeg() const { return static_cast<int>(std::lround(resolution_deg * 100.0)); }
  int turns_per_scan() const { return interlaced ? 1 : 100 / resolution_cdeg(); }
  double scan_period_s() const { return turns_per_scan() * kTurnS; }
  Unit value_unit() const { return unit == "mm" ? Unit::mm : Unit::cm; }
  /// Byte 5 of the configuration. @throws std::invalid_argument for an unknown unit or range.
  int measuring_mode() const {
    require(unit == "mm" || unit == "cm", "SICK unit is 'mm' or 'cm', not '" + unit + "'");
    const int scaled_m = unit == "mm" ? range_m : range_m / 10;
    require(scaled_m == 8 || scaled_m == 16 || scaled_m == 32,
            "SICK range_m is 8, 16 or 32 in mm, 80, 160 or 320 in cm; not " +
                std::to_string(range_m) + " in " + unit);
    return scaled_m == 8 ? 0x00 : scaled_m == 16 ? 0x04 : 0x06;
  }
};

}  // namespace marco::drivers::sick
