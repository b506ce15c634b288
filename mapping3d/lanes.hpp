#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

/// Four numbers at once, for the meshing of scenes. These are vectors of the compiler (g++ and
/// clang): the optimizer does not find them by itself in a loop with so many choices.
namespace marco::mapping3d::lanes {

using Floats = float __attribute__((vector_size(16)));
using Ints = int32_t __attribute__((vector_size(16)));
inline constexpr std::size_t kLanes = 4;

template <class Lanes, class Number>
inline Lanes read(const Number* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
template <class Lanes, class Number>
inline void write(const Lanes& lanes, Number* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}
inline Floats smaller(const Floats& a, const Floats& b) { return a < b ? a : b; }

struct Vectors {
  Floats x, y, z;
};
inline Vectors operator-(const Vectors& a, const Vectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Floats dot(const Vectors& a, const Vectors& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Floats squared(const Vectors& a) { return dot(a, a); }
inline Vectors cross(const Vectors& a, const Vectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// Choices by bits: a lane's flag is 0 or -1.
inline Floats masked(const Ints& mask, const Floats& v) {
  return reinterpret_cast<Floats>(mask & reinterpret_cast<Ints>(v));
}
inline Vectors masked(const Ints& mask, const Vectors& v) {
  return {masked(mask, v.x), masked(mask, v.y), masked(mask, v.z)};
}
inline Floats turned(const Ints& flip, const Floats& v) {
  constexpr int32_t kSign = std::numeric_limits<int32_t>::min();
  return reinterpret_cast<Floats>((flip & kSign) ^ reinterpret_cast<Ints>(v));
}
inline Vectors turned(const Ints& flip, const Vectors& v) {
  return {turned(flip, v.x), turned(flip, v.y), turned(flip, v.z)};
}
inline Floats choose(const Ints& which, const Floats& yes, const Floats& no) {
  const Ints other = reinterpret_cast<Ints>(no);
  return reinterpret_cast<Floats>(other ^ (which & (other ^ reinterpret_cast<Ints>(yes))));
}
inline Vectors choose(const Ints& which, const Vectors& yes, const Vectors& no) {
  return {choose(which, yes.x, no.x), choose(which, yes.y, no.y), choose(which, yes.z, no.z)};
}
inline Ints choose(const Ints& which, const Ints& yes, const Ints& no) {
  return no ^ (which & (no ^ yes));
}

/// Four points x y z x y z ... as three vectors, and back.
inline Vectors unravel(const Floats& a, const Floats& b, const Floats& c) {
  return {__builtin_shufflevector(__builtin_shufflevector(a, b, 0, 3, 6, -1), c, 0, 1, 2, 5),
          __builtin_shufflevector(__builtin_shufflevector(a, b, 1, 4, 7, -1), c, 0, 1, 2, 6),
          __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 5, -1, -1), c, 0, 1, 4, 7)};
}
inline void write_ravelled(const Vectors& v, float* to) {
  const Floats xy_low = __builtin_shufflevector(v.x, v.y, 0, 4, 1, 5);
  const Floats xy_high = __builtin_shufflevector(v.x, v.y, 2, 6, 3, 7);
  write(
      __builtin_shufflevector(__builtin_shufflevector(xy_low, v.z, 0, 1, 4, 2), xy_low, 0, 1, 2, 6),
      to);
  write(__builtin_shufflevector(__builtin_shufflevector(xy_low, v.z, 3, 5, -1, -1), xy_high, 0, 1,
                                4, 5),
        to + 4);
  write(__builtin_shufflevector(__builtin_shufflevector(v.z, xy_high, 2, 6, 7, 3), v.z, 0, 1, 2, 3),
        to + 8);
}

inline bool all(const Ints& flags) {
  uint64_t halves[2];
  std::memcpy(halves, &flags, sizeof halves);
  return (halves[0] & halves[1]) == ~uint64_t{0};
}

}  // namespace marco::mapping3d::lanes
