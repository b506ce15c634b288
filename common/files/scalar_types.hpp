#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace marco::files {

static_assert(std::endian::native == std::endian::little, "numbers are read as this machine's");

/// Types of the numbers in binary PLY and PCD files.
enum class Scalar : uint8_t {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};

constexpr std::size_t size_of(Scalar type) {
  constexpr std::array<uint8_t, 10> kSizes = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

enum class ByteOrder : uint8_t { little, big };

template <class Number, ByteOrder kOrder>
double load(const char* from) {
  std::array<char, sizeof(Number)> bytes;
  std::memcpy(bytes.data(), from, sizeof(Number));
  if constexpr (kOrder == ByteOrder::big) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<Number>(bytes));
}

/// The number whose size_of(type) bytes lie at `from`. Exact but for integers over 2^53.
template <ByteOrder kOrder = ByteOrder::little>
double load(const char* from, Scalar type) {
  switch (type) {
    case Scalar::int8:
      return load<int8_t, kOrder>(from);
    case Scalar::uint8:
      return load<uint8_t, kOrder>(from);
    case Scalar::int16:
      return load<int16_t, kOrder>(from);
    case Scalar::uint16:
      return load<uint16_t, kOrder>(from);
    case Scalar::int32:
      return load<int32_t, kOrder>(from);
    case Scalar::uint32:
      return load<uint32_t, kOrder>(from);
    case Scalar::int64:
      return load<int64_t, kOrder>(from);
    case Scalar::uint64:
      return load<uint64_t, kOrder>(from);
    case Scalar::float32:
      return load<float, kOrder>(from);
    case Scalar::float64:
      return load<double, kOrder>(from);
  }
  return 0.0;
}

/// A part of a colour as a byte: 0..1 of floating-point types, 0..65535 of 16 bits, else 0..255.
inline uint8_t color_byte(double value, Scalar type) {
  if (type == Scalar::float32 || type == Scalar::float64) value *= 255.0;
  if (type == Scalar::uint16) value /= 257.0;
  return value > 0.0 ? static_cast<uint8_t>(std::lround(std::min(value, 255.0))) : uint8_t{0};
}

}  // namespace marco::files
