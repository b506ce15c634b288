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

void load(const ScenePoints& scene, std::size_t number, const Limits2& limits, Row& row) {
  const std::size_t columns = scene.columns;
  const Eigen::Vector3f* const points = scene.points_m.data() + number * columns;
  const uint8_t* const valid = scene.valid.data() + number * columns;
  const Eigen::Vector3f origin_m = row.origin_m = scene.origins_m[number];
  for (std::size_t i = 0; i < columns; ++i) {
    const Eigen::Vector3f beam = points[i] - origin_m;
    const bool hit = valid[i] != 0;
    row.x[i] = hit ? points[i].x() : kFar_m;
    row.y[i] = hit ? points[i].y() : kFar_m;
    row.z[i] = hit ? points[i].z() : kFar_m;
    const float by_range = std::max(limits.floor_m2, limits.by_range * beam.squaredNorm());
    row.limit2[i] = hit ? std::min(limits.max_m2, by_range) : -1.0F;
  }
  for (std::size_t at = 0; at < columns; at += kLanes) {
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

class Mesher {
 public:
  Mesher(const ScenePoints& scene, const SceneMeshOptions& options)
      : scene_(scene), triangles_(2 * scene.columns) {
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
    const auto columns = static_cast<Eigen::Index>(row.x.size());
    const auto axis = [&](std::size_t i) {
      return Eigen::Map<const Eigen::ArrayXf>(row.normal[i].data(), columns);
    };
    Eigen::Map<Eigen::ArrayXf>(scale, columns) =
        (axis(0) * axis(0) + axis(1) * axis(1) + axis(2) * axis(2)).sqrt().max(kTiny).inverse();
    const float *const x = row.normal[0].data(), *const y = row.normal[1].data(),
                       *const z = row.normal[2].data();
    Eigen::Vector3f *const vertices_m = mesh_.vertices_m.data(), *const normals =
                                                                     mesh_.normals.data();
    uint32_t next = vertices_;
    for (std::size_t i = 0; i < scene_.columns; ++i) {
      row.vertex[i] = next;
      vertices_m[next] = {row.x[i], row.y[i], row.z[i]};
      normals[next] = {scale[i] * x[i], scale[i] * y[i], scale[i] * z[i]};
      next -= static_cast<uint32_t>(row.used[i]);
    }
    vertices_ = next;
  }

  void emit(const Row& above, const Row& below, const Quads& quads) {
    std::array<uint32_t, 3>* end = triangles_.data();
    for (std::size_t i = 0; i + 1 < scene_.columns; ++i) {
      const uint32_t v0 = above.vertex[i], v1 = above.vertex[i + 1];
      const uint32_t v2 = below.vertex[i + 1], v3 = below.vertex[i];
      const std::size_t quad = i + kLanes;
      const auto falls = static_cast<uint32_t>(quads.falling[quad]);
      // Choices by bits: which diagonal is shorter is a matter of noise, and no branch foresees it.
      const uint32_t third = v3 ^ ((v2 ^ v3) & falls), start = v1 ^ ((v0 ^ v1) & falls);
      const uint32_t swap_first = (v1 ^ third) & static_cast<uint32_t>(quads.flip_first[quad]);
      *end = {v0, v1 ^ swap_first, third ^ swap_first};
      end -= quads.keep_first[quad];
      const uint32_t swap_second = (v2 ^ v3) & static_cast<uint32_t>(quads.flip_second[quad]);
      *end = {start, v2 ^ swap_second, v3 ^ swap_second};
      end -= quads.keep_second[quad];
    }
    mesh_.triangles.insert(mesh_.triangles.end(), triangles_.data(), end);
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
