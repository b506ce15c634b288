// Configuration that people write: any text is read or refused with its place.
#include "lcm_tools/process/config.hpp"
#include "recordings/foreign.hpp"
#include "simulator/live/robot_spec.hpp"
#include "simulator/simulation_options.hpp"
#include "simulator/tour.hpp"
#include "simulator/world.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

template <class Options>
void load_and_print(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  try {
    const auto options = process::load_options<Options>(file.path());
    process::print_options(options);
  } catch (const std::invalid_argument&) {
  }
}

MARCO_FUZZ(config) {
  Input input(bytes);
  const uint8_t kind = input.byte();
  if (kind % 4 == 0) load_and_print<sim::SimulationOptions>(input.rest());
  if (kind % 4 == 1) load_and_print<sim::RobotSpec>(input.rest());
  if (kind % 4 == 2) load_and_print<sim::Tour>(input.rest());
  if (kind % 4 == 3) load_and_print<ForeignTable>(input.rest());
}

MARCO_FUZZ(world) {
  const MemoryFile file(bytes);
  try {
    const auto spec = process::load_options<sim::WorldSpec>(file.path());
    const sim::World world = sim::build_world(spec);
    promise(world.triangles.size() == world.materials.size(), "a material each triangle");
  } catch (const std::invalid_argument&) {
  }
}

}  // namespace
}  // namespace marco::fuzz
