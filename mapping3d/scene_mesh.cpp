#include "mapping3d/scene_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace marco::mapping3d {
namespace {

// Four quads go through the arithmetic at once. These are vectors of the compiler (g++ and clang):
// the optimizer does not find them by itself in a loop with so many choices.
using Floats = float __attribute__((vector_size(16)));
using Ints = int32_t __attribute__((vector_size(16)));
constexpr std::size_t kLanes = 4;

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

// Where a beam brought nothing its point is put out of every edge's reach.
constexpr float kFar_m = 1e15F;
constexpr float kTiny = 1e-30F;

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

inline Ints flags(const uint8_t* valid) {
  return Ints{valid[0], valid[1], valid[2], valid[3]} != 0;
}

void load_four(
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

void load(const ScenePoints& scene, std::size_t number, const Limits2& limits, Row& row) {
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
void judge(const Row& above, const Row& below, std::size_t at, Quads& quads) {
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
void spread(const Quads& quads, Row& above, Row& below) {
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
void mark(const Quads& quads, std::vector<int32_t>& above, std::vector<int32_t>& below) {
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

inline bool all(const Ints& flags) {
  uint64_t halves[2];
  std::memcpy(halves, &flags, sizeof halves);
  return (halves[0] & halves[1]) == ~uint64_t{0};
}

class Mesher {
 public:
  Mesher(const ScenePoints& scene, const SceneMeshOptions& options)
      : scene_(scene), triangles_(2 * (scene.columns + kLanes)) {
    const double by_range = options.edge_factor * static_cast<double>(beam_spacing_rad(scene));
    limits_ = {static_cast<float>(options.edge_floor_m * options.edge_floor_m),
               static_cast<float>(options.max_edge_m * options.max_edge_m),
               static_cast<float>(by_range * by_range)};
  }

  // A row's vertices are known when the quads above and below it are, so numbers and triangles
  // follow the quads by one row.
  TriangleMesh run() {
    const std::size_t size = (scene_.columns / kLanes + 1) * kLanes + 1;
    std::array<Row, 3> rows{Row(size), Row(size), Row(size)};
    std::array<Quads, 2> quads{Quads(size + kLanes), Quads(size + kLanes)};
    mesh_.vertices_m.resize(scene_.points_m.size());
    mesh_.normals.resize(scene_.points_m.size());
    mesh_.triangles.reserve(2 * scene_.points_m.size());
    load(scene_, 0, limits_, rows[0]);
    for (std::size_t row = 0; row + 1 < scene_.rows; ++row) {
      Row &above = rows[row % 3], &below = rows[(row + 1) % 3];
      Quads& between = quads[row % 2];
      load(scene_, row + 1, limits_, below);
      for (std::size_t at = 0; at + 1 < scene_.columns; at += kLanes) {
        judge(above, below, at, between);
      }
      spread(between, above, below);
      mark(between, above.used, below.used);
      number_vertices(above);
      if (row > 0) emit(rows[(row + 2) % 3], above, quads[(row + 1) % 2]);
    }
    const std::size_t last = scene_.rows - 1;
    number_vertices(rows[last % 3]);
    emit(rows[(last + 2) % 3], rows[last % 3], quads[(last + 1) % 2]);
    mesh_.vertices_m.resize(vertices_);
    mesh_.normals.resize(vertices_);
    return std::move(mesh_);
  }

 private:
  void number_vertices(Row& row) {
    // The limits of this row have done their work.
    float* const scale = row.limit2.data();
    const auto size = static_cast<Eigen::Index>(row.x.size());
    const auto axis = [&](std::size_t i) {
      return Eigen::Map<const Eigen::ArrayXf>(row.normal[i].data(), size);
    };
    Eigen::Map<Eigen::ArrayXf>(scale, size) =
        (axis(0) * axis(0) + axis(1) * axis(1) + axis(2) * axis(2)).sqrt().max(kTiny).inverse();
    const std::size_t columns = scene_.columns;
    for (std::size_t at = 0; at < columns; at += kLanes) {
      if (at + kLanes <= columns && all(read<Ints>(&row.used[at]))) {
        number_four(row, at);
      } else {
        for (std::size_t i = at; i < std::min(columns, at + kLanes); ++i) number_one(row, i);
      }
    }
  }

  void number_four(Row& row, std::size_t at) {
    write(Ints{0, 1, 2, 3} + static_cast<int32_t>(vertices_), &row.vertex[at]);
    write_ravelled(row.points(at), mesh_.vertices_m[vertices_].data());
    const auto scale = read<Floats>(&row.limit2[at]);
    write_ravelled(
        {scale * read<Floats>(&row.normal[0][at]), scale * read<Floats>(&row.normal[1][at]),
         scale * read<Floats>(&row.normal[2][at])},
        mesh_.normals[vertices_].data());
    vertices_ += kLanes;
  }

  void number_one(Row& row, std::size_t i) {
    row.vertex[i] = vertices_;
    if (row.used[i] == 0) return;
    mesh_.vertices_m[vertices_] = {row.x[i], row.y[i], row.z[i]};
    mesh_.normals[vertices_] = {row.limit2[i] * row.normal[0][i], row.limit2[i] * row.normal[1][i],
                                row.limit2[i] * row.normal[2][i]};
    ++vertices_;
  }

  // Which diagonal is shorter is a matter of noise, and no branch foresees it: corners are chosen
  // by bits, and of four quads' triangles all are written before those not kept are closed up.
  void emit(const Row& above, const Row& below, const Quads& quads) {
    uint32_t* end = triangles_.data()->data();
    for (std::size_t at = 0; at + 1 < scene_.columns; at += kLanes) {
      const std::size_t quad = at + kLanes;
      const auto v0 = read<Ints>(&above.vertex[at]), v1 = read<Ints>(&above.vertex[at + 1]);
      const auto v2 = read<Ints>(&below.vertex[at + 1]), v3 = read<Ints>(&below.vertex[at]);
      const auto falls = read<Ints>(&quads.falling[quad]);
      const Ints third = choose(falls, v2, v3), start = choose(falls, v0, v1);
      const Ints swap_first = (v1 ^ third) & read<Ints>(&quads.flip_first[quad]);
      const Ints swap_second = (v2 ^ v3) & read<Ints>(&quads.flip_second[quad]);
      const Ints a = v0, b = v1 ^ swap_first, c = third ^ swap_first;
      const Ints d = start, e = v2 ^ swap_second, f = v3 ^ swap_second;
      const Ints ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
      const Ints cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
      const Ints ef_low = __builtin_shufflevector(e, f, 0, 4, 1, 5);
      const Ints ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
      const Ints cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
      const Ints ef_high = __builtin_shufflevector(e, f, 2, 6, 3, 7);
      write(__builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5), end);
      write(__builtin_shufflevector(ef_low, ab_low, 0, 1, 6, 7), end + 4);
      write(__builtin_shufflevector(cd_low, ef_low, 2, 3, 6, 7), end + 8);
      write(__builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5), end + 12);
      write(__builtin_shufflevector(ef_high, ab_high, 0, 1, 6, 7), end + 16);
      write(__builtin_shufflevector(cd_high, ef_high, 2, 3, 6, 7), end + 20);
      end = all(read<Ints>(&quads.keep_first[quad]) & read<Ints>(&quads.keep_second[quad]))
                ? end + 24
                : close_up(quads, quad, end);
    }
    const auto count = static_cast<std::size_t>(end - triangles_.data()->data()) / 3;
    mesh_.triangles.insert(mesh_.triangles.end(), triangles_.begin(),
                           triangles_.begin() + static_cast<std::ptrdiff_t>(count));
  }

  static uint32_t* close_up(const Quads& quads, std::size_t quad, uint32_t* triangles) {
    uint32_t* end = triangles;
    for (std::size_t i = 0; i < 2 * kLanes; ++i) {
      const Quads::Flags& keep = i % 2 == 0 ? quads.keep_first : quads.keep_second;
      std::memmove(end, triangles + 3 * i, 3 * sizeof(uint32_t));
      end -= 3 * keep[quad + i / 2];
    }
    return end;
  }

  const ScenePoints& scene_;
  Limits2 limits_{};
  std::vector<std::array<uint32_t, 3>> triangles_;  ///< of one row of quads
  uint32_t vertices_ = 0;
  TriangleMesh mesh_;
};

}  // namespace

float beam_spacing_rad(const ScenePoints& scene) {
  constexpr std::size_t kSamples = 512;
  if (scene.rows < 2 || scene.columns < 2) return 0.0F;
  const std::size_t last = (scene.rows - 1) * scene.columns - 1;
  const std::size_t step = std::max<std::size_t>(1, last / kSamples);
  float sum = 0.0F;
  int count = 0;
  for (std::size_t at = 0; at < last; at += step) {
    const std::size_t across = at + scene.columns + 1;
    if ((at + 1) % scene.columns == 0 || scene.valid[at] == 0 || scene.valid[across] == 0) continue;
    const Eigen::Vector3f a = scene.points_m[at] - scene.origins_m[at / scene.columns];
    const Eigen::Vector3f b = scene.points_m[across] - scene.origins_m[across / scene.columns];
    sum += std::atan2(a.cross(b).norm(), a.dot(b));
    ++count;
  }
  return count > 0 ? sum / static_cast<float>(count) : 0.0F;
}

TriangleMesh mesh_scene(const ScenePoints& scene, const SceneMeshOptions& options) {
  validate(options, "scene_mesh");
  if (scene.rows < 2 || scene.columns < 2) return {};
  return Mesher(scene, options).run();
}

void append_mesh(TriangleMesh& whole, const TriangleMesh& part) {
  const auto first = static_cast<uint32_t>(whole.vertices_m.size());
  whole.vertices_m.insert(whole.vertices_m.end(), part.vertices_m.begin(), part.vertices_m.end());
  whole.normals.insert(whole.normals.end(), part.normals.begin(), part.normals.end());
  whole.colors_rgb.insert(whole.colors_rgb.end(), part.colors_rgb.begin(), part.colors_rgb.end());
  for (const auto& triangle : part.triangles) {
    whole.triangles.push_back({triangle[0] + first, triangle[1] + first, triangle[2] + first});
  }
}

}  // namespace marco::mapping3d
