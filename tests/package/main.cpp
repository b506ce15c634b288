#include <cstdio>

#include "lcm_tools/files/event_log.hpp"
#include "mapping3d/mapper3d.hpp"
#include "simulator/ray_caster.hpp"
#include "slam/slam.hpp"
#include "viewer/renderer.hpp"

int main() {
  marco::slam::Slam slam;
  marco::mapping3d::Mapper3d mapper;
  const marco::viewer::Renderer renderer;
  std::printf("%zu keyframes, %zu scenes\n", slam.key_count(), mapper.scenes().size());
}
