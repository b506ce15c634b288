#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

/// SIMD vectors of four or eight numbers for the meshing of scenes, as compiler extensions of g++
/// and clang: the optimizer does not vectorize a loop with this many branches by itself. A lane's
/// result does not depend on the number of lanes.
namespace marco::mapping3d::lanes {

template <std::size_t N>
struct Of;
template <>
struct Of<4> {
  using Floats = float __attribute__((vector_size(16)));
  using Ints = int32_t __attribute__((vector_size(16)));
};
template <>
struct Of<8> {
  using Floats = float __attribute__((vector_size(32)));
  using Ints = int32_t __attribute__((vector_size(32)));
};
using Floats = Of<4>::Floats;
using Ints = Of<4>::Ints;

// Lanes at any place in an array of their numbers. Unlike memcpy's bytes they cannot alias
// pointers, so that the arrays' own pointers are read once.
template <class Lanes>
struct InArray;
template <>
struct InArray<Of<4>::Floats> {
  using Type = float __attribute__((vector_size(16), aligned(4)));
};
template <>
struct InArray<Of<4>::Ints> {
  using Type = int32_t __attribute__((vector_size(16), aligned(4)));
};
template <>
struct InArray<Of<8>::Floats> {
  using Type = float __attribute__((vector_size(32), aligned(4)));
};
template <>
struct InArray<Of<8>::Ints> {
  using Type = int32_t __attribute__((vector_size(32), aligned(4)));
};

// Functions that pass eight lanes are always inlined.
#pragma GCC diagnostic ignored "-Wpsabi"
template <class Lanes, class Number>
inline Lanes read(const Number* from) {
  static_assert(sizeof(Number) == 4);
  return *reinterpret_cast<const typename InArray<Lanes>::Type*>(from);
}
template <class Lanes, class Number>
inline void write(const Lanes& lanes, Number* to) {
  static_assert(sizeof(Number) == 4);
  *reinterpret_cast<typename InArray<Lanes>::Type*>(to) = lanes;
}
template <class F>
inline F smaller(const F& a, const F& b) {
  return a < b ? a : b;
}

template <class F>
struct Vectors {
  F x, y, z;
};
template <class F>
inline Vectors<F> operator-(const Vectors<F>& a, const Vectors<F>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class F>
inline F dot(const Vectors<F>& a, const Vectors<F>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class F>
inline F squared(const Vectors<F>& a) {
  return dot(a, a);
}
template <class F>
inline Vectors<F> cross(const Vectors<F>& a, const Vectors<F>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// Selection by bits: a lane's flag is 0 or -1.
template <class I, class F>
inline F masked(const I& mask, const F& v) {
  return reinterpret_cast<F>(mask & reinterpret_cast<I>(v));
}
template <class I, class F>
inline Vectors<F> masked(const I& mask, const Vectors<F>& v) {
  return {masked(mask, v.x), masked(mask, v.y), masked(mask, v.z)};
}
template <class I, class F>
inline Vectors<F> turned(const I& flip, const Vectors<F>& v) {
  const I sign = flip & std::numeric_limits<int32_t>::min();
  return {reinterpret_cast<F>(sign ^ reinterpret_cast<I>(v.x)),
          reinterpret_cast<F>(sign ^ reinterpret_cast<I>(v.y)),
          reinterpret_cast<F>(sign ^ reinterpret_cast<I>(v.z))};
}
template <class I, class V>
inline V choose(const I& which, const V& yes, const V& no) {
  const I other = reinterpret_cast<I>(no);
  return reinterpret_cast<V>(other ^ (which & (other ^ reinterpret_cast<I>(yes))));
}
template <class I, class F>
inline Vectors<F> choose(const I& which, const Vectors<F>& yes, const Vectors<F>& no) {
  return {choose(which, yes.x, no.x), choose(which, yes.y, no.y), choose(which, yes.z, no.z)};
}

/// 1 / sqrt(v) of normal numbers to a few 1e-7, by Newton from a guess by the exponent; large and
/// finite at 0. The same on every machine, which the processors' own estimates are not.
template <std::size_t N>
inline typename Of<N>::Floats inverse_sqrt(const typename Of<N>::Floats& v) {
  using F = typename Of<N>::Floats;
  using I = typename Of<N>::Ints;
  const F half = 0.5F * v;
  F y = reinterpret_cast<F>(0x5f375a86 - (reinterpret_cast<I>(v) >> 1));
  for (int step = 0; step < 3; ++step) y = y * (1.5F - half * y * y);
  return y;
}

/// Four points x y z x y z ... as three vectors, and back.
inline Vectors<Floats> unravel(const Floats& a, const Floats& b, const Floats& c) {
  return {__builtin_shufflevector(__builtin_shufflevector(a, b, 0, 3, 6, -1), c, 0, 1, 2, 5),
          __builtin_shufflevector(__builtin_shufflevector(a, b, 1, 4, 7, -1), c, 0, 1, 2, 6),
          __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 5, -1, -1), c, 0, 1, 4, 7)};
}
inline void write_ravelled(const Vectors<Floats>& v, float* to) {
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
