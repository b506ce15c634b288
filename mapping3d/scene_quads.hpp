#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping3d/lanes.hpp"
#include "mapping3d/scene.hpp"

/// The quads between two rows of a scene, four at a time: which triangles are kept, and their
/// normals. Only for scene_mesh.cpp, where it is inlined.
namespace marco::mapping3d::lanes {

// Where a beam brought nothing its point is put out of every edge's reach.
inline constexpr float kFar_m = 1e15F;
inline constexpr float kTiny = 1e-30F;

/// One row of the scene in arrays, with columns that returned nothing up to whole lanes and one
/// more.
struct Row {
  explicit Row(std::size_t size)
      : x(size, kFar_m),
        y(size, kFar_m),
        z(size, kFar_m),
        limit2(size, -1.0F),
        joined(size),
        normal{std::vector<float>(size), std::vector<float>(size), std::vector<float>(size)},
        used(size),
        vertex(size) {}

  Eigen::Vector3f origin_m = Eigen::Vector3f::Zero();
  std::vector<float> x, y, z;
  std::vector<float> limit2;                 ///< of an edge that ends here [m^2]; < 0: none may
  std::vector<int32_t> joined;               ///< the edge to the next column is allowed
  std::array<std::vector<float>, 3> normal;  ///< sums, twice the area long
  std::vector<int32_t> used;                 ///< a triangle stands on it
  std::vector<uint32_t> vertex;              ///< its number in the mesh

  Vectors points(std::size_t at) const {
    return {read<Floats>(&x[at]), read<Floats>(&y[at]), read<Floats>(&z[at])};
  }
};

/// The two triangles of each quad between two rows. Corners: 0 above left, 1 above right, 2 below
/// right, 3 below left. Flags are 0 or -1, as lanes compare. The quad right of column i stands at
/// i + kLanes; before the first are quads of nothing.
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
  return Ints{valid[0], valid[1], valid[2], valid[3]} != 0;
}

inline void load_four(
    const Vectors& points, const Ints& hit, const Limits2& limits, std::size_t at, Row& row) {
  const Floats far = Floats{} + kFar_m, none = Floats{} - 1.0F;
  const Vectors origin{Floats{} + row.origin_m.x(), Floats{} + row.origin_m.y(),
                       Floats{} + row.origin_m.z()};
  const Floats by_range = limits.by_range * squared(points - origin);
  const Floats floor = Floats{} + limits.floor_m2, longest = Floats{} + limits.max_m2;
  const Floats limit = smaller(longest, choose(by_range > floor, by_range, floor));
  write(choose(hit, points.x, far), &row.x[at]);
  write(choose(hit, points.y, far), &row.y[at]);
  write(choose(hit, points.z, far), &row.z[at]);
  write(choose(hit, limit, none), &row.limit2[at]);
}

inline void load(const ScenePoints& scene, std::size_t number, const Limits2& limits, Row& row) {
  const std::size_t columns = scene.columns;
  const Eigen::Vector3f* const points = scene.points_m.data() + number * columns;
  const uint8_t* const valid = scene.valid.data() + number * columns;
  row.origin_m = scene.origins_m[number];
  std::size_t at = 0;
  for (; at + kLanes <= columns; at += kLanes) {
    const float* const from = points[at].data();
    load_four(unravel(read<Floats>(from), read<Floats>(from + 4), read<Floats>(from + 8)),
              flags(valid + at), limits, at, row);
  }
  if (at < columns) {
    std::array<Eigen::Vector3f, kLanes> rest{};
    std::array<uint8_t, kLanes> rest_valid{};
    std::copy(points + at, points + columns, rest.begin());
    std::copy(valid + at, valid + columns, rest_valid.begin());
    const float* const from = rest[0].data();
    load_four(unravel(read<Floats>(from), read<Floats>(from + 4), read<Floats>(from + 8)),
              flags(rest_valid.data()), limits, at, row);
  }
  for (at = 0; at < columns; at += kLanes) {
    const Floats limit2 = smaller(read<Floats>(&row.limit2[at]), read<Floats>(&row.limit2[at + 1]));
    const Ints joined = squared(row.points(at + 1) - row.points(at)) <= limit2;
    write(joined, &row.joined[at]);
  }
  for (auto& sum : row.normal) std::fill(sum.begin(), sum.end(), 0.0F);
  std::fill(row.used.begin(), row.used.end(), 0);
}

inline void write(const Vectors& v, std::size_t at, std::array<std::vector<float>, 3>& to) {
  write(v.x, &to[0][at]);
  write(v.y, &to[1][at]);
  write(v.z, &to[2][at]);
}

/// Judges the four quads from column `at` on: a triangle is kept when its three edges are allowed.
inline void judge(const Row& above, const Row& below, std::size_t at, Quads& quads) {
  const Vectors p0 = above.points(at), p1 = above.points(at + 1);
  const Vectors p2 = below.points(at + 1), p3 = below.points(at);
  const auto l0 = read<Floats>(&above.limit2[at]), l1 = read<Floats>(&above.limit2[at + 1]);
  const auto l2 = read<Floats>(&below.limit2[at + 1]), l3 = read<Floats>(&below.limit2[at]);
  const Floats fall2 = squared(p0 - p2), rise2 = squared(p1 - p3);
  const Ints falls = fall2 <= rise2;
  const Ints left = squared(p0 - p3) <= smaller(l0, l3);
  const Ints right = squared(p1 - p2) <= smaller(l1, l2);
  const Ints diagonal = smaller(fall2, rise2) <= choose(falls, smaller(l0, l2), smaller(l1, l3));
  const Vectors third = choose(falls, p2, p3), start = choose(falls, p0, p1);
  const Vectors first = cross(p1 - p0, third - p0), second = cross(p2 - start, p3 - start);
  const Vectors origin{Floats{} + above.origin_m.x(), Floats{} + above.origin_m.y(),
                       Floats{} + above.origin_m.z()};
  // Exactly edge-on: a triangle of nothing.
  const Floats away_first = dot(first, p0 - origin), away_second = dot(second, start - origin);
  const Ints keep_first =
      read<Ints>(&above.joined[at]) & choose(falls, right, left) & diagonal & (away_first != 0.0F);
  const Ints keep_second =
      read<Ints>(&below.joined[at]) & choose(falls, left, right) & diagonal & (away_second != 0.0F);
  const Ints flip_first = away_first > 0.0F, flip_second = away_second > 0.0F;
  const std::size_t to = at + kLanes;
  write(falls, &quads.falling[to]);
  write(keep_first, &quads.keep_first[to]);
  write(keep_second, &quads.keep_second[to]);
  write(flip_first, &quads.flip_first[to]);
  write(flip_second, &quads.flip_second[to]);
  write(masked(keep_first, turned(flip_first, first)), to, quads.first);
  write(masked(keep_second, turned(flip_second, second)), to, quads.second);
}

/// Adds the quads' normals to their corners: the first triangle always stands on corners 0 and 1,
/// the second on 2 and 3, and each on one of the other's by the diagonal.
inline void spread(const Quads& quads, Row& above, Row& below) {
  for (std::size_t at = 0; at + kLanes < above.x.size(); at += kLanes) {
    const std::size_t right = at + kLanes, left = right - 1;  // quads of which this is a corner
    const auto falls_right = read<Ints>(&quads.falling[right]);
    const auto falls_left = read<Ints>(&quads.falling[left]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto first_right = read<Floats>(&quads.first[axis][right]);
      const auto first_left = read<Floats>(&quads.first[axis][left]);
      const auto second_right = read<Floats>(&quads.second[axis][right]);
      const auto second_left = read<Floats>(&quads.second[axis][left]);
      float *top = &above.normal[axis][at], *bottom = &below.normal[axis][at];
      write(read<Floats>(top) + (first_right + first_left) +
                (masked(falls_right, second_right) + masked(~falls_left, second_left)),
            top);
      write(read<Floats>(bottom) + (second_right + second_left) +
                (masked(~falls_right, first_right) + masked(falls_left, first_left)),
            bottom);
    }
  }
}

/// Marks the corners of kept triangles.
inline void mark(const Quads& quads, std::vector<int32_t>& above, std::vector<int32_t>& below) {
  for (std::size_t at = 0; at + kLanes < above.size(); at += kLanes) {
    const std::size_t right = at + kLanes, left = right - 1;
    const auto falls_right = read<Ints>(&quads.falling[right]);
    const auto falls_left = read<Ints>(&quads.falling[left]);
    const auto first_right = read<Ints>(&quads.keep_first[right]);
    const auto first_left = read<Ints>(&quads.keep_first[left]);
    const auto second_right = read<Ints>(&quads.keep_second[right]);
    const auto second_left = read<Ints>(&quads.keep_second[left]);
    const Ints top =
        first_right | first_left | (falls_right & second_right) | (~falls_left & second_left);
    const Ints bottom =
        second_right | second_left | (~falls_right & first_right) | (falls_left & first_left);
    write(read<Ints>(&above[at]) | top, &above[at]);
    write(read<Ints>(&below[at]) | bottom, &below[at]);
  }
}

}  // namespace marco::mapping3d::lanes
