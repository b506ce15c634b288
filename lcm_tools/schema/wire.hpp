#pragma once

#include <cstdint>
#include <cstring>

#include "lcm_tools/schema/schema.hpp"

/// Single values as LCM writes them: big endian, unaligned. The caller has checked the length.
namespace marco::lcm_schema {

template <class Int>
Int load(const uint8_t* bytes) {
  Int value;
  std::memcpy(&value, bytes, sizeof(Int));
  if constexpr (sizeof(Int) == 8)
    value = static_cast<Int>(__builtin_bswap64(static_cast<uint64_t>(value)));
  if constexpr (sizeof(Int) == 4)
    value = static_cast<Int>(__builtin_bswap32(static_cast<uint32_t>(value)));
  if constexpr (sizeof(Int) == 2)
    value = static_cast<Int>(__builtin_bswap16(static_cast<uint16_t>(value)));
  return value;
}

/// Any integer, boolean or byte; 0 for other types.
inline int64_t load_integer(Primitive primitive, const uint8_t* bytes) {
  switch (primitive) {
    case Primitive::int8:
    case Primitive::boolean:
      return static_cast<int8_t>(*bytes);
    case Primitive::byte:
      return *bytes;
    case Primitive::int16:
      return load<int16_t>(bytes);
    case Primitive::int32:
      return load<int32_t>(bytes);
    case Primitive::int64:
      return load<int64_t>(bytes);
    default:
      return 0;
  }
}

}  // namespace marco::lcm_schema
