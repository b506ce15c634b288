#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace marco::files {

/// Appends an integer's bytes, the least significant first, as bags and MCAP files have them.
template <class Int>
void put(std::string& to, Int value) {
  for (std::size_t i = 0; i < sizeof(Int); ++i) {
    to += static_cast<char>(static_cast<uint64_t>(value) >> (8 * i));
  }
}

}  // namespace marco::files
