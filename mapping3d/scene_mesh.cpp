#include "mapping3d/scene_mesh.hpp"

#include <algorithm>

#include "mapping3d/scene_quads.hpp"

namespace marco::mapping3d {
namespace {

using namespace lanes;

class Mesher {
 public:
  Mesher(const ScenePoints& scene, const SceneMeshOptions& options)
      : scene_(scene), triangles_(2 * (scene.columns + 4)) {
    const double by_range = options.edge_factor * static_cast<double>(beam_spacing_rad(scene));
    limits_ = {static_cast<float>(options.edge_floor_m * options.edge_floor_m),
               static_cast<float>(options.max_edge_m * options.max_edge_m),
               static_cast<float>(by_range * by_range)};
  }

  // The vertices of a row depend on the quads above and below it, so that numbering and triangles
  // are one row behind the quads.
  template <std::size_t N>
  TriangleMesh run() {
    mesh_.vertices_m.resize(scene_.points_m.size());
    mesh_.normals.resize(scene_.points_m.size());
    mesh_.triangles.reserve(2 * scene_.points_m.size());
    std::array<Row, 3>& rows = rows_;
    std::array<Quads, 2>& quads = quads_;
    load<N>(scene_, 0, limits_, rows[0]);
    for (std::size_t row = 0; row + 1 < scene_.rows; ++row) {
      Row &above = rows[row % 3], &below = rows[(row + 1) % 3];
      Quads& between = quads[row % 2];
      load<N>(scene_, row + 1, limits_, below);
      for (std::size_t at = 0; at + 1 < scene_.columns; at += N) {
        judge<N>(above, below, at, between);
      }
      spread<N>(between, above, below);
      number_vertices<N>(above);
      if (row > 0) emit(rows[(row + 2) % 3], above, quads[(row + 1) % 2]);
    }
    const std::size_t last = scene_.rows - 1;
    number_vertices<N>(rows[last % 3]);
    emit(rows[(last + 2) % 3], rows[last % 3], quads[(last + 1) % 2]);
    mesh_.vertices_m.resize(vertices_);
    mesh_.normals.resize(vertices_);
    return std::move(mesh_);
  }

 private:
  template <std::size_t N>
  void number_vertices(Row& row) {
    using F = typename Of<N>::Floats;
    const std::size_t columns = scene_.columns;
    for (std::size_t at = 0; at < columns; at += N) {
      const Vectors<F> sum{read<F>(&row.normal[0][at]), read<F>(&row.normal[1][at]),
                           read<F>(&row.normal[2][at])};
      const F scale = inverse_sqrt<N>(squared(sum));
      write(scale * sum.x, &row.normal[0][at]);
      write(scale * sum.y, &row.normal[1][at]);
      write(scale * sum.z, &row.normal[2][at]);
    }
    for (std::size_t at = 0; at < columns; at += 4) {
      if (at + 4 <= columns && all(read<Ints>(&row.used[at]))) {
        number_four(row, at);
      } else {
        for (std::size_t i = at; i < std::min(columns, at + 4); ++i) number_one(row, i);
      }
    }
  }

  void number_four(Row& row, std::size_t at) {
    write(Ints{0, 1, 2, 3} + static_cast<int32_t>(vertices_), &row.vertex[at]);
    write_ravelled(row.points<Floats>(at), mesh_.vertices_m[vertices_].data());
    write_ravelled({read<Floats>(&row.normal[0][at]), read<Floats>(&row.normal[1][at]),
                    read<Floats>(&row.normal[2][at])},
                   mesh_.normals[vertices_].data());
    vertices_ += 4;
  }

  void number_one(Row& row, std::size_t i) {
    row.vertex[i] = vertices_;
    if (row.used[i] == 0) return;
    mesh_.vertices_m[vertices_] = {row.x[i], row.y[i], row.z[i]};
    mesh_.normals[vertices_] = {row.normal[0][i], row.normal[1][i], row.normal[2][i]};
    ++vertices_;
  }

  // The shorter diagonal is random and branches on it cannot be predicted: corners are selected by
  // bits, and the triangles of four quads are all written before the dropped ones are closed up.
  void emit(const Row& above, const Row& below, const Quads& quads) {
    uint32_t* end = triangles_.data()->data();
    for (std::size_t at = 0; at + 1 < scene_.columns; at += 4) {
      const std::size_t quad = at + kMostLanes;
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
    for (std::size_t i = 0; i < 8; ++i) {
      const Quads::Flags& keep = i % 2 == 0 ? quads.keep_first : quads.keep_second;
      std::memmove(end, triangles + 3 * i, 3 * sizeof(uint32_t));
      end -= std::ptrdiff_t{3} * keep[quad + i / 2];
    }
    return end;
  }

  const ScenePoints& scene_;
  Limits2 limits_{};
  std::size_t size_ = (scene_.columns / kMostLanes + 1) * kMostLanes + 1;
  std::array<Row, 3> rows_{Row(size_), Row(size_), Row(size_)};
  std::array<Quads, 2> quads_{Quads(size_ + kMostLanes), Quads(size_ + kMostLanes)};
  std::vector<std::array<uint32_t, 3>> triangles_;  ///< of one row of quads
  uint32_t vertices_ = 0;
  TriangleMesh mesh_;
};

#if defined(__x86_64__)
// Everything is inlined into this one function, so that code for newer processors is not called on
// older ones. The arithmetic is the same: no fused multiply-add.
__attribute__((target("avx2"), flatten)) TriangleMesh run_wide(Mesher& mesher) {
  return mesher.run<8>();
}
bool has_wide_lanes() { return __builtin_cpu_supports("avx2") != 0; }
#else
TriangleMesh run_wide(Mesher& mesher) { return mesher.run<8>(); }
bool has_wide_lanes() { return false; }
#endif

}  // namespace

float beam_spacing_rad(const ScenePoints& scene) {
  constexpr std::size_t kSamples = 512;  // enough for a mean
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

TriangleMesh mesh_scene(const ScenePoints& scene, const SceneMeshOptions& options, Lanes lanes) {
  validate(options, "scene_mesh");
  if (scene.rows < 2 || scene.columns < 2) return {};
  Mesher mesher(scene, options);
  return has_wide_lanes() && lanes == Lanes::as_many_as_there_are ? run_wide(mesher)
                                                                  : mesher.run<4>();
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
