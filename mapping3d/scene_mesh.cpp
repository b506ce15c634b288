#include "mapping3d/scene_mesh.hpp"

#include <algorithm>
#include <limits>

#include "mapping3d/scene_quads.hpp"

namespace marco::mapping3d {
namespace {

using namespace lanes;

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
