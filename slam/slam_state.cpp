#include "slam/slam_state.hpp"

#include "lcm_tools/base/check.hpp"

namespace marco::slam {

void check(const SlamState& state) {
  check(state.keyframes);
  check(state.back_end, state.keyframes);
  check(state.path, state.keyframes);
  check(state.culling, state.keyframes);
  check(state.gate);
  require(is_near(state.estimate.world_from_robot), "the robot is farther away than 1000 km");
}

}  // namespace marco::slam
