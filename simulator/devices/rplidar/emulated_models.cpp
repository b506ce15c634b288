#include "simulator/devices/rplidar/emulator.hpp"

namespace marco::drivers::rplidar {

// A3: 16 kHz; S1: 9.2 kHz.
RplidarEmulatorOptions a3() {
  RplidarEmulatorOptions options;
  options.model = 0x31;
  options.baud = 256'000;
  options.turns_per_s = 10.0;
  options.sample_s = 250e-6;
  options.express_s = 62.5e-6;
  options.capsules = kUltraCapsules;
  options.range_max_m = 25.0;
  return options;
}

RplidarEmulatorOptions s1() {
  RplidarEmulatorOptions options = a3();
  options.model = 0x61;
  options.sample_s = 200e-6;
  options.express_s = 108.7e-6;
  options.range_max_m = 40.0;
  return options;
}

// C1: 5 kHz, S2: 32 kHz.
RplidarEmulatorOptions c1() {
  RplidarEmulatorOptions options;
  options.model = 0x41;
  options.baud = 460'800;
  options.turns_per_s = 10.0;
  options.sample_s = options.express_s = 200e-6;
  options.capsules = kDenseCapsules;
  return options;
}

RplidarEmulatorOptions s2() {
  RplidarEmulatorOptions options = c1();
  options.model = 0x71;
  options.baud = 1'000'000;
  options.sample_s = 200e-6;
  options.express_s = 31.25e-6;
  options.range_max_m = 30.0;
  return options;
}

// 32 kHz.
RplidarEmulatorOptions s3() {
  RplidarEmulatorOptions options = s2();
  options.model = 0x81;
  options.capsules = kUltraDenseCapsules;
  options.range_max_m = 40.0;
  return options;
}

}  // namespace marco::drivers::rplidar
