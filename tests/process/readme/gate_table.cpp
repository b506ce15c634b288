// docs/gates.md's tables, from the constants that decide: readme_test compares.
#include <cstdio>
#include <span>

#include "common/input/input_gates.hpp"
#include "mapping3d/sweep_gates.hpp"
#include "slam/back_end/loop_gates.hpp"
#include "slam/doctor/doctor_gates.hpp"
#include "slam/front_end/match_gates.hpp"
#include "slam/localization/place_gates.hpp"

namespace {

void print(const char* title, std::span<const marco::Gate> gates) {
  std::printf("\n## %s\n\n| gate | quantity | threshold | then | source |\n|---|---|---|---|---|\n",
              title);
  for (const marco::Gate& gate : gates) {
    std::printf("| %s | %s | %g | %s | %s |\n", gate.name, gate.quantity, gate.threshold,
                gate.consequence, gate.source);
  }
}

}  // namespace

int main() {
  print("Sensor data (`common/input/input_gates.hpp`)", marco::input_gates::kInputGates);
  print("Sweeps of a laser on a pan-tilt (`mapping3d/sweep_gates.hpp`)",
        marco::mapping3d::sweep_gates::kSweepGates);
  print("Matches (`slam/front_end/match_gates.hpp`)", marco::slam::kMatchGates);
  print("Loop closures (`slam/back_end/loop_gates.hpp`)", marco::slam::kLoopGates);
  print("Places in a saved map (`slam/localization/place_gates.hpp`)", marco::slam::kPlaceGates);
  print("The verdict (`slam/doctor/doctor_gates.hpp`)", marco::slam::doctor_gates::kDoctorGates);
  return 0;
}
