#include "viewer/detail_levels.hpp"

#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "common/mesh_distance.hpp"

namespace marco::viewer {
namespace {

// A corner's normal that is farther from its face's is of a crease: the cosine of 30 deg.
constexpr float kSmooth = 0.866F;
// Share of the area about a vertex that makes a face of its own; slivers lie as noise has it.
constexpr float kWorthACorner = 0.1F;

/// Twice the area long.
Eigen::Vector3f normal_of(const Geometry& of, std::size_t triangle) {
  const auto at = [&](std::size_t corner) {
    return Eigen::Vector3f(of.vertices[of.indices[3 * triangle + corner]].position_m.data());
  };
  return (at(1) - at(0)).cross(at(2) - at(0));
}

/// A vertex at a crease has a normal between those of its faces. On triangles of some centimetres
/// that is a soft edge; one of a metre is shaded wrong all over. Such a corner gets a vertex of its
/// own, with the normal of the faces around it that lie the same way; the vertices that were there
/// stay.
/// @param surfaces  triangles; their places do not change
void split_creases(Geometry& surfaces) {
  std::vector<std::vector<std::size_t>> about(surfaces.vertices.size());
  std::vector<Eigen::Vector3f> normals(surfaces.indices.size() / 3);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    normals[i] = normal_of(surfaces, i);
    for (std::size_t k = 0; k < 3; ++k) about[surfaces.indices[3 * i + k]].push_back(i);
  }
  for (std::size_t i = 0; i < surfaces.indices.size(); ++i) {
    const uint32_t index = surfaces.indices[i];
    const Eigen::Vector3f face = normals[i / 3].normalized();
    const Vertex corner = surfaces.vertices[index];
    const Eigen::Vector3f own = corner.unit_normal();
    if (own.isZero() || std::abs(own.dot(face)) > kSmooth) continue;
    Eigen::Vector3f alike = Eigen::Vector3f::Zero();
    float all = 0.0F;
    for (const std::size_t other : about[index]) {
      all += normals[other].norm();
      if (normals[other].dot(face) > kSmooth * normals[other].norm()) alike += normals[other];
    }
    if (!(alike.norm() > kWorthACorner * all)) continue;
    surfaces.indices[i] = static_cast<uint32_t>(surfaces.vertices.size());
    surfaces.vertices.push_back(corner);
    surfaces.vertices.back().set_normal((own.dot(alike) < 0.0F ? -1.0F : 1.0F) *
                                        alike.normalized());
  }
}

constexpr float kSmallestPartM = 0.3F;
constexpr std::size_t kFewest = 200;  // triangles that are worth two parts
// The quadric errors that levels are made for. A quadric looks at the planes of single triangles,
// and calls a wall with 3 mm of noise off by 13 mm once it is two triangles: how far a level really
// is off is measured.
constexpr std::array<float, 9> kErrorsM{0.004F, 0.006F, 0.009F, 0.013F, 0.018F,
                                        0.026F, 0.037F, 0.055F, 0.1F};
// A level that spares less is not worth its place.
constexpr double kWorthwhile = 0.9;
// What joining two parts may add to the quadric error of their triangles.
constexpr float kMoreByJoining = 0.5F;
// Of a part, from which a level's distance is measured.
constexpr std::size_t kSamples = 1000;

// A box lies outside when all its corners lie beyond one side of the clip space.
bool may_be_seen(const Eigen::Matrix4d& clip_from_world,
                 const Eigen::Vector3d& low_m,
                 const Eigen::Vector3d& high_m) {
  std::array<int, 6> outside{};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d at((corner & 1) != 0 ? high_m.x() : low_m.x(),
                             (corner & 2) != 0 ? high_m.y() : low_m.y(),
                             (corner & 4) != 0 ? high_m.z() : low_m.z());
    const Eigen::Vector4d clip = clip_from_world * at.homogeneous();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double value = clip[static_cast<Eigen::Index>(axis)];
      outside[2 * axis] += value > clip.w() ? 1 : 0;
      outside[2 * axis + 1] += value < -clip.w() ? 1 : 0;
    }
  }
  return *std::max_element(outside.begin(), outside.end()) < 8;
}

constexpr uint32_t kUnnumbered = std::numeric_limits<uint32_t>::max();

/// Some triangles, with only the vertices that they use.
/// @param numbers  scratch, a kUnnumbered for each vertex of `all`; left as it was
Geometry extracted(const Geometry& all,
                   std::span<const uint32_t> indices,
                   std::vector<uint32_t>& numbers) {
  Geometry some;
  std::vector<uint32_t> used;
  for (const uint32_t index : indices) {
    uint32_t& number = numbers[index];
    if (number == kUnnumbered) {
      number = static_cast<uint32_t>(used.size());
      used.push_back(index);
      some.vertices.push_back(all.vertices[index]);
    }
    some.indices.push_back(number);
  }
  for (const uint32_t index : used) numbers[index] = kUnnumbered;
  return some;
}

}  // namespace

class DetailLevels::Builder {
 public:
  Builder(const Geometry& surfaces, DetailLevels& levels)
      : surfaces_(surfaces), levels_(levels), own_(surfaces.vertices.size(), kUnnumbered) {
    triangles_.resize(surfaces.indices.size() / 3);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const uint32_t* const at = &surfaces.indices[3 * i];
      triangles_[i] = {at[0], at[1], at[2]};
    }
    if (!triangles_.empty()) build(0, triangles_.size());
  }

 private:
  using Triangle = std::array<uint32_t, 3>;

  Eigen::Vector3f position(uint32_t index) const {
    return Eigen::Vector3f(surfaces_.vertices[index].position_m.data());
  }
  float middle(const Triangle& triangle, Eigen::Index axis) const {
    return (position(triangle[0])[axis] + position(triangle[1])[axis] +
            position(triangle[2])[axis]) /
           3.0F;
  }

  int build(std::size_t begin, std::size_t end) {
    Part part{Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()),
              Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity()),
              {}};
    for (std::size_t i = begin; i < end; ++i) {
      for (const uint32_t index : triangles_[i]) {
        part.low_m = part.low_m.cwiseMin(position(index).cast<double>());
        part.high_m = part.high_m.cwiseMax(position(index).cast<double>());
      }
    }
    const std::size_t middle = split(part, begin, end);
    if (middle == begin || middle == end) {
      make_levels_of_a_leaf(part, begin, end);
    } else {
      part.first = build(begin, middle);
      part.second = build(middle, end);
      join_levels(part, begin, end);
    }
    levels_.parts_.push_back(std::move(part));
    return static_cast<int>(levels_.parts_.size()) - 1;
  }

  // Across the longest side, where the fewest triangles lie: a border within a wall or a floor that
  // runs along it would tear that into shreds, all of rims, that nothing makes coarser.
  std::size_t split(const Part& part, std::size_t begin, std::size_t end) {
    Eigen::Index axis = 0;
    const auto length_m = static_cast<float>((part.high_m - part.low_m).maxCoeff(&axis));
    if (length_m < 2.0F * kSmallestPartM || end - begin < 2 * kFewest) return begin;
    constexpr int kSlices = 64;
    std::array<std::size_t, kSlices> slices{};
    const auto low_m = static_cast<float>(part.low_m[axis]);
    const auto slice = [&](const Triangle& triangle) {
      const float at = (middle(triangle, axis) - low_m) / length_m;
      return std::clamp(static_cast<int>(at * kSlices), 0, kSlices - 1);
    };
    for (std::size_t i = begin; i < end; ++i)
      ++slices[static_cast<std::size_t>(slice(triangles_[i]))];
    int best = kSlices / 2;
    const auto crossed = [&](int border) {
      return slices[static_cast<std::size_t>(border)] +
             slices[static_cast<std::size_t>(border) - 1];
    };
    for (int away = 1; away <= kSlices / 5; ++away) {
      for (const int border : {kSlices / 2 - away, kSlices / 2 + away}) {
        if (crossed(border) < crossed(best)) best = border;
      }
    }
    const auto first = triangles_.begin();
    return static_cast<std::size_t>(
        std::partition(first + static_cast<std::ptrdiff_t>(begin),
                       first + static_cast<std::ptrdiff_t>(end),
                       [&](const Triangle& triangle) { return slice(triangle) < best; }) -
        first);
  }

  void make_levels_of_a_leaf(Part& part, std::size_t begin, std::size_t end) {
    std::vector<uint32_t> all;
    for (std::size_t i = begin; i < end; ++i) {
      all.insert(all.end(), triangles_[i].begin(), triangles_[i].end());
    }
    keep(part, all, 0, 0.0);
    for (std::size_t step = 1; step <= kErrorsM.size(); ++step) {
      const std::vector<uint32_t> fewer = simplified(all, kErrorsM[step - 1]);
      if (fewer.size() < worthwhile(part.levels.back().range.count)) {
        keep(part, fewer, step, distance_m(begin, end, fewer, kErrorsM[step - 1]));
      }
    }
  }

  void join_levels(Part& part, std::size_t begin, std::size_t end) {
    for (std::size_t step = 1; step <= kErrorsM.size(); ++step) {
      std::vector<uint32_t> both;
      gather(part.first, step, both);
      gather(part.second, step, both);
      const std::vector<uint32_t> fewer = simplified(both, kMoreByJoining * kErrorsM[step - 1]);
      const std::size_t last = part.levels.empty() ? both.size() : part.levels.back().range.count;
      if (fewer.size() < worthwhile(std::min(last, both.size()))) {
        keep(part, fewer, step, distance_m(begin, end, fewer, kErrorsM[step - 1]));
      }
    }
  }

  static std::size_t worthwhile(std::size_t count) {
    return static_cast<std::size_t>(kWorthwhile * static_cast<double>(count));
  }

  // How far the triangles' corners are from those of a level, at most.
  // @param expected_m  the search ends at twice this distance, which is returned for all beyond
  double distance_m(std::size_t begin,
                    std::size_t end,
                    const std::vector<uint32_t>& level,
                    float expected_m) const {
    TriangleMesh mesh;
    for (std::size_t i = 0; i + 2 < level.size(); i += 3) {
      const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
      for (std::size_t k = 0; k < 3; ++k) mesh.vertices_m.push_back(position(level[i + k]));
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    const MeshDistance distance(mesh, 2.0F * expected_m);
    const std::size_t every = 1 + (end - begin) / kSamples;
    float farthest_m = 0.0F;
    for (std::size_t i = begin; i < end; i += every) {
      farthest_m = std::max(farthest_m, distance(position(triangles_[i][0])));
    }
    return static_cast<double>(farthest_m);
  }

  // Appends a part's triangles at a step, or finer.
  void gather(int number, std::size_t step, std::vector<uint32_t>& to) const {
    const Part& part = levels_.parts_[static_cast<std::size_t>(number)];
    const Level* best = nullptr;
    for (const Level& level : part.levels) {
      if (level.step == step || (part.first == kNone && level.step < step)) best = &level;
    }
    if (best == nullptr) {
      gather(part.first, step, to);
      gather(part.second, step, to);
      return;
    }
    const auto from = levels_.indices_.begin() + static_cast<std::ptrdiff_t>(best->range.first);
    to.insert(to.end(), from, from + static_cast<std::ptrdiff_t>(best->range.count));
  }

  // The library's time goes with the vertices it is shown, so that it gets the triangles' own.
  std::vector<uint32_t> simplified(const std::vector<uint32_t>& indices, float error_m) {
    std::vector<uint32_t> used, local, fewer(indices.size());
    std::vector<float> places;
    for (const uint32_t index : indices) {
      if (own_[index] == kUnnumbered) {
        own_[index] = static_cast<uint32_t>(used.size());
        used.push_back(index);
        const auto& p = surfaces_.vertices[index].position_m;
        places.insert(places.end(), p.begin(), p.end());
      }
      local.push_back(own_[index]);
    }
    const float extent_m =
        std::max(1e-6F, meshopt_simplifyScale(places.data(), used.size(), 3 * sizeof(float)));
    fewer.resize(meshopt_simplify(fewer.data(), local.data(), local.size(), places.data(),
                                  used.size(), 3 * sizeof(float), 0, error_m / extent_m,
                                  meshopt_SimplifyLockBorder, nullptr));
    meshopt_optimizeVertexCache(fewer.data(), fewer.data(), fewer.size(), used.size());
    for (uint32_t& index : fewer) index = used[index];
    for (const uint32_t index : used) own_[index] = kUnnumbered;
    return fewer;
  }

  void keep(Part& part, const std::vector<uint32_t>& level, std::size_t step, double error_m) {
    std::vector<uint32_t>& all = levels_.indices_;
    part.levels.push_back({{all.size(), level.size()}, step, error_m});
    all.insert(all.end(), level.begin(), level.end());
  }

  const Geometry& surfaces_;
  DetailLevels& levels_;
  std::vector<Triangle> triangles_;
  std::vector<uint32_t> own_;  ///< a vertex's number in the part at hand
};

DetailLevels::DetailLevels(const Geometry& surfaces) { Builder(surfaces, *this); }

Geometry DetailLevels::packed(const Geometry& surfaces) const {
  Geometry packed;
  packed.indices.resize(indices_.size());
  std::vector<uint32_t> numbers(surfaces.vertices.size(), kUnnumbered);
  std::vector<uint32_t> ordered, places;
  for (const Part& part : parts_) {
    for (const Level& level : part.levels) {
      const std::span<const uint32_t> of_level(indices_.data() + level.range.first,
                                               level.range.count);
      Geometry own = extracted(surfaces, of_level, numbers);
      if (level.step > 0) split_creases(own);
      ordered.resize(own.indices.size());
      meshopt_optimizeVertexCache(ordered.data(), own.indices.data(), own.indices.size(),
                                  own.vertices.size());
      places.assign(own.vertices.size(), kUnnumbered);
      for (std::size_t i = 0; i < ordered.size(); ++i) {
        uint32_t& place = places[ordered[i]];
        if (place == kUnnumbered) {
          place = static_cast<uint32_t>(packed.vertices.size());
          packed.vertices.push_back(own.vertices[ordered[i]]);
        }
        packed.indices[level.range.first + i] = place;
      }
    }
  }
  return packed;
}

struct DetailLevels::Choice {
  struct Piece {
    Range range;
    double distance_m = 0.0;
  };
  std::vector<Piece> pieces;
  std::size_t count = 0;
};

DetailLevels::Choice DetailLevels::choose(const View& view, int number) const {
  const Part& part = parts_[static_cast<std::size_t>(number)];
  Choice best;
  if (!may_be_seen(view.clip_from_world, part.low_m, part.high_m)) return best;
  const Eigen::Vector3d nearest_m = view.eye_m.cwiseMax(part.low_m).cwiseMin(part.high_m);
  const double distance_m = (nearest_m - view.eye_m).norm();
  const double allowed_m = view.allowed_px * (view.perspective ? distance_m : 1.0) / view.px_per_m;
  const Level* own = nullptr;
  for (const Level& level : part.levels) {
    if (level.error_m <= allowed_m) own = &level;
  }
  if (part.first != kNone) {
    best = choose(view, part.first);
    Choice second = choose(view, part.second);
    best.count += second.count;
    best.pieces.insert(best.pieces.end(), second.pieces.begin(), second.pieces.end());
  }
  if (own != nullptr && (part.first == kNone || own->range.count < best.count)) {
    best = {{{own->range, distance_m}}, own->range.count};
  }
  return best;
}

std::vector<DetailLevels::Range> DetailLevels::choose(const View& view) const {
  std::vector<Range> ranges;
  if (parts_.empty()) return ranges;
  Choice choice = choose(view, static_cast<int>(parts_.size()) - 1);
  std::stable_sort(choice.pieces.begin(), choice.pieces.end(),
                   [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
  for (const Choice::Piece& piece : choice.pieces) ranges.push_back(piece.range);
  return ranges;
}

}  // namespace marco::viewer
