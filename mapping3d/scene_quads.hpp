#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping3d/lanes.hpp"
#include "mapping3d/scene.hpp"

/// The quads between two rows of a scene, four or eight at a time: which triangles are kept, and
/// their normals. Only for scene_mesh.cpp, where it is inlined.
namespace marco::mapping3d::lanes {

// Rows are padded for it, whatever the number of lanes.
inline constexpr std::size_t kMostLanes = 8;
// Coordinates of a missing beam: too far for any edge.
inline constexpr float kFarM = 1e15F;

/// One row of the scene in arrays, padded by missing beams to whole lanes and one more.
struct Row {
  explicit Row(std::size_t size)
      : x(size, kFarM),
        y(size, kFarM),
        z(size, kFarM),
        limit2(size, -1.0F),
        joined(size),
        normal{std::vector<float>(size), std::vector<float>(size), std::vector<float>(size)},
        used(size),
        vertex(size) {}

  Eigen::Vector3f origin_m = Eigen::Vector3f::Zero();
  std::vector<float> x, y, z;
  std::vector<float> limit2;                 ///< of an edge that ends here [m^2]; < 0: none
  std::vector<int32_t> joined;               ///< the edge to the next column is allowed
  std::array<std::vector<float>, 3> normal;  ///< sums, twice the area long
  std::vector<int32_t> used;                 ///< a triangle stands on it
  std::vector<uint32_t> vertex;              ///< its number in the mesh

  template <class F>
  Vectors<F> points(std::size_t at) const {
    return {read<F>(&x[at]), read<F>(&y[at]), read<F>(&z[at])};
  }
  template <class F>
  Vectors<F> origin() const {
    return {F{} + origin_m.x(), F{} + origin_m.y(), F{} + origin_m.z()};
  }
};

/// The two triangles of each quad between two rows. Corners: 0 above left, 1 above right, 2 below
/// right, 3 below left. Flags are 0 or -1, as lanes compare. The quad right of column i stands at
/// i + kMostLanes; before the first are quads of nothing.
struct Quads {
  explicit Quads(std::size_t size)
      : falling(size),
        keep_first(size),
        keep_second(size),
        flip_first(size),
        flip_second(size),
        first{Numbers(size), Numbers(size), Numbers(size)},
        second{Numbers(size), Numbers(size), Numbers(size)} {}

  using Flags = std::vector<int32_t>;
  using Numbers = std::vector<float>;
  Flags falling;  ///< the diagonal runs 0-2, triangles 012 and 023; else 013 and 123
  Flags keep_first, keep_second;         ///< the triangle is allowed
  Flags flip_first, flip_second;         ///< from the sensor its corners run clockwise
  std::array<Numbers, 3> first, second;  ///< normals, twice the area long, 0 where not kept
};

struct Limits2 {
  float floor_m2;
  float max_m2;
  float by_range;  ///< times range^2
};

inline Ints flags(const uint8_t* valid) {
  using Bytes = uint8_t __attribute__((vector_size(4)));
  Bytes bytes;
  std::memcpy(&bytes, valid, sizeof bytes);
  return __builtin_convertvector(bytes, Ints) != 0;
}

inline void load_four(const Vectors<Floats>& points,
                      const Ints& hit,
                      const Limits2& limits,
                      std::size_t at,
                      Row& row) {
  const Floats far = Floats{} + kFarM, none = Floats{} - 1.0F;
  const Floats by_range = limits.by_range * squared(points - row.origin<Floats>());
  const Floats floor = Floats{} + limits.floor_m2, longest = Floats{} + limits.max_m2;
  const Floats limit = smaller(longest, choose(by_range > floor, by_range, floor));
  write(choose(hit, points.x, far), &row.x[at]);
  write(choose(hit, points.y, far), &row.y[at]);
  write(choose(hit, points.z, far), &row.z[at]);
  write(choose(hit, limit, none), &row.limit2[at]);
}

template <std::size_t N>
inline void load(const ScenePoints& scene, std::size_t number, const Limits2& limits, Row& row) {
  const std::size_t columns = scene.columns;
  const Eigen::Vector3f* const points = scene.points_m.data() + number * columns;
  const uint8_t* const valid = scene.valid.data() + number * columns;
  row.origin_m = scene.origins_m[number];
  std::size_t at = 0;
  for (; at + 4 <= columns; at += 4) {
    const float* const from = points[at].data();
    load_four(unravel(read<Floats>(from), read<Floats>(from + 4), read<Floats>(from + 8)),
              flags(valid + at), limits, at, row);
  }
  if (at < columns) {
    std::array<Eigen::Vector3f, 4> rest{};
    std::array<uint8_t, 4> rest_valid{};
    std::copy(points + at, points + columns, rest.begin());
    std::copy(valid + at, valid + columns, rest_valid.begin());
    const float* const from = rest[0].data();
    load_four(unravel(read<Floats>(from), read<Floats>(from + 4), read<Floats>(from + 8)),
              flags(rest_valid.data()), limits, at, row);
  }
  using F = typename Of<N>::Floats;
  for (at = 0; at < columns; at += N) {
    const F limit2 = smaller(read<F>(&row.limit2[at]), read<F>(&row.limit2[at + 1]));
    const typename Of<N>::Ints joined =
        squared(row.points<F>(at + 1) - row.points<F>(at)) <= limit2;
    write(joined, &row.joined[at]);
  }
}

template <class F>
inline void write(const Vectors<F>& v, std::size_t at, std::array<std::vector<float>, 3>& to) {
  write(v.x, &to[0][at]);
  write(v.y, &to[1][at]);
  write(v.z, &to[2][at]);
}

/// Judges the quads from column `at` on: a triangle is kept when its three edges are allowed.
template <std::size_t N>
inline void judge(const Row& above, const Row& below, std::size_t at, Quads& quads) {
  using F = typename Of<N>::Floats;
  using I = typename Of<N>::Ints;
  const Vectors<F> p0 = above.points<F>(at), p1 = above.points<F>(at + 1);
  const Vectors<F> p2 = below.points<F>(at + 1), p3 = below.points<F>(at);
  const auto l0 = read<F>(&above.limit2[at]), l1 = read<F>(&above.limit2[at + 1]);
  const auto l2 = read<F>(&below.limit2[at + 1]), l3 = read<F>(&below.limit2[at]);
  const F fall2 = squared(p0 - p2), rise2 = squared(p1 - p3);
  const I falls = fall2 <= rise2;
  const I left = squared(p0 - p3) <= smaller(l0, l3);
  const I right = squared(p1 - p2) <= smaller(l1, l2);
  const I diagonal = smaller(fall2, rise2) <= choose(falls, smaller(l0, l2), smaller(l1, l3));
  const Vectors<F> third = choose(falls, p2, p3), start = choose(falls, p0, p1);
  const Vectors<F> first = cross(p1 - p0, third - p0), second = cross(p2 - start, p3 - start);
  const Vectors<F> origin = above.origin<F>();
  // An exactly edge-on triangle is dropped.
  const F away_first = dot(first, p0 - origin), away_second = dot(second, start - origin);
  const I keep_first =
      read<I>(&above.joined[at]) & choose(falls, right, left) & diagonal & (away_first != 0.0F);
  const I keep_second =
      read<I>(&below.joined[at]) & choose(falls, left, right) & diagonal & (away_second != 0.0F);
  const I flip_first = away_first > 0.0F, flip_second = away_second > 0.0F;
  const std::size_t to = at + kMostLanes;
  write(falls, &quads.falling[to]);
  write(keep_first, &quads.keep_first[to]);
  write(keep_second, &quads.keep_second[to]);
  write(flip_first, &quads.flip_first[to]);
  write(flip_second, &quads.flip_second[to]);
  write(masked(keep_first, turned(flip_first, first)), to, quads.first);
  write(masked(keep_second, turned(flip_second, second)), to, quads.second);
}

/// Adds the quads' normals to their corners and marks those of kept triangles: the first triangle
/// always stands on corners 0 and 1, the second on 2 and 3, and each on one of the other's by the
/// diagonal. For the row below these are the first.
template <std::size_t N>
inline void spread(const Quads& quads, Row& above, Row& below) {
  using F = typename Of<N>::Floats;
  using I = typename Of<N>::Ints;
  for (std::size_t at = 0; at + N < above.x.size(); at += N) {
    const std::size_t right = at + kMostLanes, left = right - 1;  // quads of which this is a corner
    const auto falls_right = read<I>(&quads.falling[right]);
    const auto falls_left = read<I>(&quads.falling[left]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto first_right = read<F>(&quads.first[axis][right]);
      const auto first_left = read<F>(&quads.first[axis][left]);
      const auto second_right = read<F>(&quads.second[axis][right]);
      const auto second_left = read<F>(&quads.second[axis][left]);
      float *top = &above.normal[axis][at], *bottom = &below.normal[axis][at];
      write(read<F>(top) + (first_right + first_left) +
                (masked(falls_right, second_right) + masked(~falls_left, second_left)),
            top);
      write((second_right + second_left) +
                (masked(~falls_right, first_right) + masked(falls_left, first_left)),
            bottom);
    }
    const auto first_right = read<I>(&quads.keep_first[right]);
    const auto first_left = read<I>(&quads.keep_first[left]);
    const auto second_right = read<I>(&quads.keep_second[right]);
    const auto second_left = read<I>(&quads.keep_second[left]);
    const I top =
        first_right | first_left | (falls_right & second_right) | (~falls_left & second_left);
    const I bottom =
        second_right | second_left | (~falls_right & first_right) | (falls_left & first_left);
    write(read<I>(&above.used[at]) | top, &above.used[at]);
    write(bottom, &below.used[at]);
  }
}

}  // namespace marco::mapping3d::lanes
