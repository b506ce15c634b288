#include "common/files/points/lzf.hpp"

#include <cstdint>

#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

// A control byte below 32 says how many literal bytes follow, less one. Otherwise its upper three
// bits are a length less two (7: a byte to be added follows), its lower five and the next byte the
// distance back, less one.
constexpr std::size_t kLiterals = 32, kLongLength = 7;
constexpr std::size_t kMostOfThreeBytes = kLongLength + 255 + 2;

}  // namespace

std::string unpack_lzf(std::string_view packed, std::size_t bytes, const std::string& name) {
  const auto check = [&](bool holds) {
    if (!holds) throw std::invalid_argument(name + ": its compressed points are damaged");
  };
  check(bytes / kMostOfThreeBytes <= packed.size() / 3 + 1);
  std::string out;
  out.reserve(bytes);
  std::size_t at = 0;
  const auto next_byte = [&]() -> std::size_t {
    check(at < packed.size());
    return static_cast<uint8_t>(packed[at++]);
  };
  while (at < packed.size()) {
    const std::size_t control = next_byte();
    if (control < kLiterals) {
      const std::size_t count = control + 1;
      check(count <= packed.size() - at && count <= bytes - out.size());
      out.append(packed, at, count);
      at += count;
      continue;
    }
    std::size_t length = control >> 5U;
    if (length == kLongLength) length += next_byte();
    length += 2;
    const std::size_t distance = ((control & 31U) << 8U) + next_byte() + 1;
    check(distance <= out.size() && length <= bytes - out.size());
    // Byte by byte: the copy may reach into itself.
    for (std::size_t i = 0; i < length; ++i) out += out[out.size() - distance];
  }
  check(out.size() == bytes);
  return out;
}

}  // namespace marco::files
