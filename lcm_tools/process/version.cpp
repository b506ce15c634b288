#include "lcm_tools/process/version.hpp"

// In revision.o (lcm_tools/cmake/revision.cmake), absent from an installed package.
extern "C" __attribute__((weak)) const char marco_revision[];  // NOLINT: as the linker knows it

namespace marco::process {

std::string version() {
  const std::string revision = marco_revision == nullptr ? "" : marco_revision;
  return revision.empty() ? MARCO_VERSION : MARCO_VERSION " (" + revision + ")";
}

}  // namespace marco::process
