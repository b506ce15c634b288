#include "mapping3d/scene_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace marco::mapping3d {
namespace {

// Where a beam brought nothing its point is put out of every edge's reach.
constexpr float kFar_m = 1e15F;

/// One row of the scene as arrays a loop can take four or eight at a time.
struct Row {
  explicit Row(std::size_t columns)
      : x(columns),
        y(columns),
        z(columns),
        limit2(columns),
        normal_x(columns),
        normal_y(columns),
        normal_z(columns),
        used(columns),
        vertex(columns) {}

  Eigen::Vector3f origin_m = Eigen::Vector3f::Zero();
  std::vector<float> x, y, z;
  std::vector<float> limit2;  ///< of an edge that ends here [m^2]; < 0: none may
  std::vector<float> normal_x, normal_y, normal_z;  ///< sums, twice the area long
  std::vector<int32_t> used;                        ///< 1: a triangle stands on it
  std::vector<uint32_t> vertex;                     ///< its number in the mesh
};

/// The two triangles of each quad between two rows. Corners: 0 above left, 1 above right, 2 below
/// right, 3 below left.
struct Quads {
  explicit Quads(std::size_t columns)
      : falling(columns), keep{Ints(columns), Ints(columns)}, flip{Ints(columns), Ints(columns)} {
    for (auto* normal : {&first, &second}) normal->assign(3, std::vector<float>(columns));
  }
  using Ints = std::vector<int32_t>;
  Ints falling;  ///< 1: the diagonal runs 0-2, triangles 012 and 023; else 013 and 123
  Ints keep[2];  ///< 1: the triangle is allowed
  Ints flip[2];  ///< 1: seen from the sensor its corners run clockwise
  std::vector<std::vector<float>> first, second;  ///< normals of the triangles, 0 where not kept
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
  row.origin_m = scene.origins_m[number];
  const float origin_x = row.origin_m.x(), origin_y = row.origin_m.y(), origin_z = row.origin_m.z();
  float* __restrict const x = row.x.data();
  float* __restrict const y = row.y.data();
  float* __restrict const z = row.z.data();
  float* __restrict const limit2 = row.limit2.data();
  for (std::size_t i = 0; i < columns; ++i) {
    const bool hit = valid[i] != 0;
    x[i] = hit ? points[i].x() : kFar_m;
    y[i] = hit ? points[i].y() : kFar_m;
    z[i] = hit ? points[i].z() : kFar_m;
  }
  for (std::size_t i = 0; i < columns; ++i) {
    const float beam_x = x[i] - origin_x, beam_y = y[i] - origin_y, beam_z = z[i] - origin_z;
    const float range2 = beam_x * beam_x + beam_y * beam_y + beam_z * beam_z;
    const float by_range = std::max(limits.floor_m2, limits.by_range * range2);
    limit2[i] = x[i] < kFar_m ? std::min(limits.max_m2, by_range) : -1.0F;
  }
  for (auto* sum : {&row.normal_x, &row.normal_y, &row.normal_z}) {
    std::fill(sum->begin(), sum->end(), 0.0F);
  }
  std::fill(row.used.begin(), row.used.end(), 0);
}

struct Vec {
  float x, y, z;
};
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline float dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float squared(const Vec& a) { return dot(a, a); }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec choose(bool which, const Vec& yes, const Vec& no) {
  return {which ? yes.x : no.x, which ? yes.y : no.y, which ? yes.z : no.z};
}

/// Judges all quads between two rows, without a branch.
void judge(const Row& above, const Row& below, Quads& quads) {
  const std::size_t count = above.x.size() - 1;
  const float *ax = above.x.data(), *ay = above.y.data(), *az = above.z.data();
  const float *bx = below.x.data(), *by = below.y.data(), *bz = below.z.data();
  const float *al = above.limit2.data(), *bl = below.limit2.data();
  const Vec above_origin{above.origin_m.x(), above.origin_m.y(), above.origin_m.z()};
  int32_t* __restrict const falling = quads.falling.data();
  int32_t* __restrict const keep_first = quads.keep[0].data();
  int32_t* __restrict const keep_second = quads.keep[1].data();
  int32_t* __restrict const flip_first = quads.flip[0].data();
  int32_t* __restrict const flip_second = quads.flip[1].data();
  float* __restrict const fx = quads.first[0].data();
  float* __restrict const fy = quads.first[1].data();
  float* __restrict const fz = quads.first[2].data();
  float* __restrict const sx = quads.second[0].data();
  float* __restrict const sy = quads.second[1].data();
  float* __restrict const sz = quads.second[2].data();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec p0{ax[i], ay[i], az[i]}, p1{ax[i + 1], ay[i + 1], az[i + 1]};
    const Vec p2{bx[i + 1], by[i + 1], bz[i + 1]}, p3{bx[i], by[i], bz[i]};
    const float fall2 = squared(p0 - p2), rise2 = squared(p1 - p3);
    const bool falls = fall2 <= rise2;
    const bool top = squared(p0 - p1) <= std::min(al[i], al[i + 1]);
    const bool bottom = squared(p3 - p2) <= std::min(bl[i], bl[i + 1]);
    const bool left = squared(p0 - p3) <= std::min(al[i], bl[i]);
    const bool right = squared(p1 - p2) <= std::min(al[i + 1], bl[i + 1]);
    const bool fall = fall2 <= std::min(al[i], bl[i + 1]);
    const bool rise = rise2 <= std::min(al[i + 1], bl[i]);
    const bool diagonal = falls ? fall : rise;
    const Vec third = choose(falls, p2, p3), start = choose(falls, p0, p1);
    const Vec first = cross(p1 - p0, third - p0), second = cross(p2 - start, p3 - start);
    const bool keeps_first = top & (falls ? right : left) & diagonal & (squared(first) > 0.0F);
    const bool keeps_second = bottom & (falls ? left : right) & diagonal & (squared(second) > 0.0F);
    const bool flips_first = dot(first, p0 - above_origin) > 0.0F;
    const bool flips_second = dot(second, start - above_origin) > 0.0F;
    const float first_sign = keeps_first ? (flips_first ? -1.0F : 1.0F) : 0.0F;
    const float second_sign = keeps_second ? (flips_second ? -1.0F : 1.0F) : 0.0F;
    falling[i] = falls ? 1 : 0;
    keep_first[i] = keeps_first ? 1 : 0;
    keep_second[i] = keeps_second ? 1 : 0;
    flip_first[i] = flips_first ? 1 : 0;
    flip_second[i] = flips_second ? 1 : 0;
    fx[i] = first_sign * first.x;
    fy[i] = first_sign * first.y;
    fz[i] = first_sign * first.z;
    sx[i] = second_sign * second.x;
    sy[i] = second_sign * second.y;
    sz[i] = second_sign * second.z;
  }
}

/// Adds what the quads' triangles give to their corners: the first always stands on 0 and 1, the
/// second on 2 and 3, and each on one corner of the other's by the diagonal.
template <class Number>
void spread(const std::vector<int32_t>& falling,
            const std::vector<Number>& first,
            const std::vector<Number>& second,
            std::vector<Number>& above,
            std::vector<Number>& below) {
  const std::size_t count = above.size() - 1;
  Number* __restrict const top = above.data();
  Number* __restrict const bottom = below.data();
  const int32_t* __restrict const falls = falling.data();
  const Number* __restrict const one = first.data();
  const Number* __restrict const two = second.data();
  for (std::size_t i = 0; i < count; ++i) {
    top[i] += one[i] + (falls[i] != 0 ? two[i] : Number{});
    bottom[i] += two[i] + (falls[i] != 0 ? Number{} : one[i]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    top[i + 1] += one[i] + (falls[i] != 0 ? Number{} : two[i]);
    bottom[i + 1] += two[i] + (falls[i] != 0 ? one[i] : Number{});
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
    const std::size_t columns = scene_.columns;
    Row rows[3] = {Row(columns), Row(columns), Row(columns)};
    Quads quads[2] = {Quads(columns), Quads(columns)};
    mesh_.vertices_m.resize(scene_.points_m.size());
    mesh_.normals.resize(scene_.points_m.size());
    mesh_.triangles.reserve(2 * scene_.points_m.size());
    load(scene_, 0, limits_, rows[0]);
    for (std::size_t row = 0; row + 1 < scene_.rows; ++row) {
      Row &above = rows[row % 3], &below = rows[(row + 1) % 3];
      Quads& between = quads[row % 2];
      load(scene_, row + 1, limits_, below);
      judge(above, below, between);
      spread(between.falling, between.first[0], between.second[0], above.normal_x, below.normal_x);
      spread(between.falling, between.first[1], between.second[1], above.normal_y, below.normal_y);
      spread(between.falling, between.first[2], between.second[2], above.normal_z, below.normal_z);
      spread(between.falling, between.keep[0], between.keep[1], above.used, below.used);
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
    const auto columns = static_cast<Eigen::Index>(scene_.columns);
    Eigen::Map<Eigen::ArrayXf> x(row.normal_x.data(), columns), y(row.normal_y.data(), columns),
        z(row.normal_z.data(), columns), length(row.limit2.data(), columns);
    // The limits of this row have done their work.
    length = (x * x + y * y + z * z).sqrt();
    for (std::size_t i = 0; i < scene_.columns; ++i) {
      row.vertex[i] = static_cast<uint32_t>(vertices_);
      mesh_.vertices_m[vertices_] = {row.x[i], row.y[i], row.z[i]};
      const float scale = row.limit2[i] > 0.0F ? 1.0F / row.limit2[i] : 0.0F;
      mesh_.normals[vertices_] = {scale * row.normal_x[i], scale * row.normal_y[i],
                                  scale * row.normal_z[i]};
      vertices_ += row.used[i] != 0 ? 1 : 0;
    }
  }

  void emit(const Row& above, const Row& below, const Quads& quads) {
    std::array<uint32_t, 3>* end = triangles_.data();
    for (std::size_t i = 0; i + 1 < scene_.columns; ++i) {
      const bool falls = quads.falling[i] != 0;
      const uint32_t v0 = above.vertex[i], v1 = above.vertex[i + 1];
      const uint32_t v2 = below.vertex[i + 1], v3 = below.vertex[i];
      const uint32_t third = falls ? v2 : v3, start = falls ? v0 : v1;
      const bool flip_first = quads.flip[0][i] != 0, flip_second = quads.flip[1][i] != 0;
      *end = {v0, flip_first ? third : v1, flip_first ? v1 : third};
      end += quads.keep[0][i];
      *end = {start, flip_second ? v3 : v2, flip_second ? v2 : v3};
      end += quads.keep[1][i];
    }
    mesh_.triangles.insert(mesh_.triangles.end(), triangles_.data(), end);
  }

  const ScenePoints& scene_;
  Limits2 limits_{};
  std::vector<std::array<uint32_t, 3>> triangles_;  ///< of one row of quads
  std::size_t vertices_ = 0;
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
