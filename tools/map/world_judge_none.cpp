#include <stdexcept>

#include "tools/map/judge.hpp"

namespace marco {

Errors judge_against_world(const MapJob& /*job*/,
                           const GridMap& /*map*/,
                           const TriangleMesh& /*model*/,
                           const std::filesystem::path& world_file) {
  throw std::runtime_error("--world " + world_file.string() +
                           ": this build has no simulator to compare with; install Embree "
                           "(libembree-dev), configure and build again");
}

}  // namespace marco
