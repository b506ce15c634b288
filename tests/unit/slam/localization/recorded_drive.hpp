#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "slam/slam.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {

/// By what factor wheels count too much.
struct WheelErrors {
  double of_way = 1.03, of_turn = 1.02;
};

/// What laser and wheels say along a path, five scans a second. @param seed  of the laser's noise.
inline std::vector<SlamInput> recorded_drive(const testing::FlatWorld& world,
                                             const std::vector<Pose2>& path,
                                             uint32_t seed,
                                             int64_t start_us,
                                             const WheelErrors& errors = {}) {
  std::mt19937 random(seed);
  Pose2 odom;
  std::vector<SlamInput> inputs;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i > 0) {
      const Pose2 step = between(path[i - 1], path[i]);
      odom = odom * Pose2{errors.of_way * step.x_m, step.y_m, errors.of_turn * step.theta_rad};
    }
    SlamInput input;
    input.scan.utime = Utime::from_us(start_us + static_cast<int64_t>(i) * 200000);
    input.scan.hits_in_robot = world.hits(path[i], 0.01, &random);
    input.motion = {input.scan.utime, odom, {}};
    inputs.push_back(std::move(input));
  }
  return inputs;
}

}  // namespace marco::slam
