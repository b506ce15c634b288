#include <cstdio>

#include "common/files/event_log.hpp"
#include "drivers/simulator/ray_caster.hpp"
#include "mapping3d/mapper3d.hpp"
#include "slam/slam.hpp"
#include "viewer/renderer.hpp"

int main() {
  marco::slam::Slam slam;
  marco::mapping3d::Mapper3d mapper;
  const marco::viewer::Renderer renderer;
  std::printf("%zu key scans, %zu scenes\n", slam.key_count(), mapper.scenes().size());
}
