#pragma once

#include <cstdio>
#include <cstdlib>

namespace marco::testing {

/// The folder of recordings that are not ours to ship, by MARCO_TEST_DATA; says SKIPPED where there
/// is none.
inline const char* real_data() {
  const char* folder = std::getenv("MARCO_TEST_DATA");
  if (folder == nullptr) std::puts("SKIPPED: MARCO_TEST_DATA is not set");
  return folder;
}

}  // namespace marco::testing
