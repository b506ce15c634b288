#include "mapping3d/surface/small_pieces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "mapping3d/surface/islands.hpp"
#include "mapping3d/surface/mesh_distance.hpp"

namespace marco::mapping3d {
namespace {

using Triangle = std::array<uint32_t, 3>;
using Piece = std::vector<Triangle>;  ///< facets as indices of the scene's returns

/// A scene's facets between returns that are `bare`, joined to pieces by common returns.
class SceneFacets {
 public:
  SceneFacets(const SmoothScene& scene,
              const FacetOptions& options,
              const std::vector<uint8_t>& bare)
      : scene_(scene), joined_(scene.points_m.size()) {
    for (const Triangle& facet : facets(scene, options)) {
      if (bare[facet[0]] == 0 || bare[facet[1]] == 0 || bare[facet[2]] == 0) continue;
      facets_.push_back(facet);
      joined_.join(facet[0], facet[1]);
      joined_.join(facet[1], facet[2]);
    }
  }

  /// Those of things; mixed ranges are left out.
  std::vector<Piece> pieces() {
    std::map<uint32_t, Piece> pieces;
    for (const Triangle& facet : facets_) pieces[joined_.root(facet[0])].push_back(facet);
    std::vector<Piece> kept;
    for (auto& [of, piece] : pieces) {
      if (!is_mixed(piece)) kept.push_back(std::move(piece));
    }
    return kept;
  }

 private:
  // Counted by facets, so that a return counts as often as it has facets.
  bool is_mixed(const Piece& piece) {
    std::size_t mixed = 0;
    for (const Triangle& facet : piece) {
      for (const uint32_t i : facet) mixed += is_mixed(i) ? 1 : 0;
    }
    return 2 * mixed > 3 * piece.size();
  }

  bool is_mixed(uint32_t i) {
    const std::size_t row = i / scene_.columns, column = i % scene_.columns;
    return is_between(i, {column, scene_.columns - 1 - column}, 1) ||
           is_between(i, {row, scene_.rows - 1 - row}, static_cast<int64_t>(scene_.columns));
  }

  // Whether its range lies between those of the first returns beside its piece, on both sides.
  bool is_between(uint32_t i, const std::array<std::size_t, 2>& neighbours, int64_t stride) {
    const float before_m = beside_m(i, neighbours[0], -stride);
    const float after_m = beside_m(i, neighbours[1], stride), own_m = range_m(i);
    return before_m > 0.0F && after_m > 0.0F && (before_m < own_m) == (own_m < after_m);
  }

  float beside_m(uint32_t i, std::size_t neighbours, int64_t stride) {
    const uint32_t own = joined_.root(i);
    int64_t next = i;
    for (std::size_t k = 0; k < neighbours; ++k) {
      next += stride;
      const auto at = static_cast<uint32_t>(next);
      if (scene_.kinds[at] == SmoothScene::Kind::none) return 0.0F;
      if (joined_.root(at) != own) return range_m(at);
    }
    return 0.0F;
  }

  float range_m(std::size_t i) const {
    return (scene_.points_m[i] - scene_.origins_m[i / scene_.columns]).norm();
  }

  const SmoothScene& scene_;
  Islands joined_;
  std::vector<Triangle> facets_;
};

/// The pieces of all scenes, in voxels.
class SmallPieces {
 public:
  explicit SmallPieces(const SurfaceOptions& options)
      : per_m_(static_cast<float>(1.0 / options.voxel_m)),
        every_(static_cast<std::size_t>(options.carve_every)) {}

  /// @param bare  of each return: whether the mesh has nothing near it
  void add(std::size_t number,
           const SmoothScene& scene,
           std::vector<uint8_t> bare,
           const FacetOptions& options) {
    for (std::size_t i = 0; i < bare.size(); ++i) {
      if (bare[i] != 0 && is_taken(scene.points_m[i], scene.normals[i])) bare[i] = 0;
    }
    for (Piece& piece : SceneFacets(scene, options, bare).pieces()) {
      pieces_.push_back({number, std::move(piece)});
      for (const Triangle& facet : pieces_.back().facets) {
        for (const uint32_t i : facet) take(scene.points_m[i], scene.normals[i]);
      }
    }
  }

  /// Counts whether another scene sees the pieces or what is behind them.
  void look(std::size_t number, const SmoothScene& scene) {
    std::vector<std::array<int, 2>> beams(pieces_.size());  // that end there, that go through
    for (std::size_t row = 0; row < scene.rows; row += every_) {
      for (std::size_t column = 0; column < scene.columns; column += every_) {
        const std::size_t i = row * scene.columns + column;
        if (scene.kinds[i] != SmoothScene::Kind::none) {
          follow(scene.origins_m[row], scene.points_m[i], beams);
        }
      }
    }
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      const auto [ended, through] = beams[k];
      if (pieces_[k].scene == number) continue;
      if (through >= kBeams && ended * kBeams < through) ++pieces_[k].absent;
      if (ended >= kBeams) ++pieces_[k].present;
    }
  }

  void write(const std::vector<SmoothScene>& scenes, TriangleMesh& mesh) const {
    for (const Found& piece : pieces_) {
      if (piece.absent >= piece.present) continue;
      const SmoothScene& scene = scenes[piece.scene];
      std::unordered_map<uint32_t, uint32_t> vertex_of;
      for (Triangle facet : piece.facets) {
        for (uint32_t& corner : facet) {
          const auto next = static_cast<uint32_t>(mesh.vertices_m.size());
          const auto [entry, is_new] = vertex_of.try_emplace(corner, next);
          if (is_new) {
            mesh.vertices_m.push_back(scene.points_m[corner]);
            mesh.normals.push_back(scene.normals[corner]);
          }
          corner = entry->second;
        }
        mesh.triangles.push_back(facet);
      }
    }
  }

 private:
  static constexpr int kBeams = 3;  ///< fewer may be errors of poses
  static constexpr float kBehind =
      2.0F;  ///< a beam that ends this many voxels farther went through
  struct Found {
    std::size_t scene;
    Piece facets;
    int present = 1;  ///< scenes that see it, its own among them
    int absent = 0;   ///< scenes that see what is behind it
  };
  struct Voxel {
    std::size_t piece = 0;                             ///< 1 more than its index
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< sum
  };

  Cell cell_of(const Eigen::Vector3f& point_m) const {
    return (point_m * per_m_).array().round().cast<int>();
  }

  void take(const Eigen::Vector3f& point_m, const Eigen::Vector3f& normal) {
    Voxel& voxel = voxels_.voxel(cell_of(point_m));
    if (voxel.piece == 0) voxel.piece = pieces_.size();
    voxel.normal += normal;
  }

  bool is_taken(const Eigen::Vector3f& point_m, const Eigen::Vector3f& normal) const {
    const Cell middle = cell_of(point_m);
    for (int i = 0; i < 27; ++i) {
      const Voxel* near = voxels_.find_voxel(middle + Cell(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
      if (near != nullptr && near->normal.dot(normal) > 0.0F) return true;
    }
    return false;
  }

  void follow(const Eigen::Vector3f& origin_m,
              const Eigen::Vector3f& end_m,
              std::vector<std::array<int, 2>>& beams) const {
    const Eigen::Vector3f from = origin_m * per_m_, way = end_m * per_m_ - from;
    const float length = way.norm();
    std::size_t last = 0;
    voxels_.walk(from, way / std::max(1e-6F, length), length + kBehind,
                 [&](const Voxel& voxel, float t) {
                   if (voxel.piece == 0 || voxel.piece == last) return;
                   last = voxel.piece;
                   ++beams[last - 1][t < length - kBehind ? 1 : 0];
                 });
  }

  float per_m_;
  std::size_t every_;
  std::vector<Found> pieces_;
  VoxelBlocks<Voxel> voxels_;
};

}  // namespace

void add_small_pieces(const std::vector<SmoothScene>& scenes,
                      const SurfaceOptions& options,
                      TriangleMesh& mesh) {
  const auto near_m = static_cast<float>(2.0 * options.voxel_m);
  const MeshDistance distance(mesh, near_m);
  SmallPieces pieces(options);
  for (std::size_t number = 0; number < scenes.size(); ++number) {
    const SmoothScene& scene = scenes[number];
    std::vector<uint8_t> bare(scene.points_m.size(), 0);
    for (std::size_t i = 0; i < bare.size(); ++i) {
      bare[i] = scene.kinds[i] != SmoothScene::Kind::none && distance(scene.points_m[i]) >= near_m;
    }
    pieces.add(number, scene, std::move(bare), options.facets);
  }
  for (std::size_t number = 0; number < scenes.size(); ++number) {
    pieces.look(number, scenes[number]);
  }
  pieces.write(scenes, mesh);
}

}  // namespace marco::mapping3d
