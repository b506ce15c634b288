// What libFuzzer calls: the target of this program that --target=NAME chooses.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/fuzz/target.hpp"

namespace {
const marco::fuzz::Target* chosen = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  constexpr const char* kFlag = "--target=";
  for (int i = 1; i < *argc; ++i) {
    if (std::strncmp((*argv)[i], kFlag, std::strlen(kFlag)) != 0) continue;
    for (const marco::fuzz::Target& target : marco::fuzz::targets()) {
      if (std::strcmp(target.name, (*argv)[i] + std::strlen(kFlag)) == 0) chosen = &target;
    }
  }
  if (chosen != nullptr) return 0;
  std::fprintf(stderr, "usage: %s --target=NAME [libFuzzer's flags] [CORPUS...]\n", (*argv)[0]);
  for (const marco::fuzz::Target& target : marco::fuzz::targets()) std::puts(target.name);
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  chosen->run({data, size});
  return 0;
}
