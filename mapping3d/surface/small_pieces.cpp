#include "mapping3d/surface/small_pieces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <unordered_map>

#include "common/triangle_mesh.hpp"
#include "mapping3d/scene_mesh.hpp"
#include "mapping3d/surface/islands.hpp"
#include "mapping3d/surface/voxel_blocks.hpp"

namespace marco::mapping3d {
namespace {

/// Whether a point lies within about two voxels of a fused mesh, which has a vertex in each voxel
/// that it passes. Const members are safe from several threads.
class NearMesh {
 public:
  NearMesh(const TriangleMesh& mesh, double voxel_m) : per_m_(static_cast<float>(1.0 / voxel_m)) {
    std::vector<Cell> ball;
    for (int i = 0; i < 125; ++i) {
      const Cell offset(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2);
      if (offset.squaredNorm() <= kReach * kReach) ball.push_back(offset);
    }
    for (const Eigen::Vector3f& vertex_m : mesh.vertices_m) {
      const Cell middle = cell_of(vertex_m);
      for (const Cell& offset : ball) near_.voxel(middle + offset) = 1;
    }
  }
  bool operator()(const Eigen::Vector3f& point_m) const {
    const uint8_t* const voxel = near_.find_voxel(cell_of(point_m));
    return voxel != nullptr && *voxel != 0;
  }

 private:
  static constexpr int kReach = 2;
  Cell cell_of(const Eigen::Vector3f& point_m) const {
    return (point_m * per_m_).array().round().cast<int>();
  }

  float per_m_;
  VoxelBlocks<uint8_t> near_;
};

using Triangle = std::array<uint32_t, 3>;
/// Of one scene, by the indices of its returns.
struct Piece {
  std::vector<Triangle> facets;
  /// Or a thing that is hit by one beam of each row, or of each column: a leg, a rail.
  std::vector<uint32_t> chain;
  float half_width_m = 0.0F;  ///< of the chain
};
constexpr std::size_t kChain = 4;  // shorter ones are noise

/// A scene's facets between returns that are `bare`, joined to pieces by common returns.
class SceneFacets {
 public:
  SceneFacets(const SmoothScene& scene,
              const FacetOptions& options,
              const std::vector<uint8_t>& bare)
      : scene_(scene), options_(options), joined_(scene.points_m.size()), alone_(bare) {
    for (const Triangle& facet : facets(scene, options)) {
      if (bare[facet[0]] == 0 || bare[facet[1]] == 0 || bare[facet[2]] == 0) continue;
      facets_.push_back(facet);
      for (const uint32_t i : facet) alone_[i] = 0;
      joined_.join(facet[0], facet[1]);
      joined_.join(facet[1], facet[2]);
    }
  }

  /// Those of things; mixed ranges are left out.
  std::vector<Piece> pieces() {
    std::map<uint32_t, Piece> pieces;
    for (const Triangle& facet : facets_) pieces[joined_.root(facet[0])].facets.push_back(facet);
    std::vector<Piece> kept;
    for (auto& [of, piece] : pieces) {
      if (!is_mixed(piece)) kept.push_back(std::move(piece));
    }
    find_chains(scene_.columns, kept);
    find_chains(1, kept);
    return kept;
  }

 private:
  // Counted by facets, so that a return counts as often as it has facets.
  bool is_mixed(const Piece& piece) {
    std::size_t mixed = 0;
    for (const Triangle& facet : piece.facets) {
      for (const uint32_t i : facet) mixed += is_mixed(i) ? 1 : 0;
    }
    return 2 * mixed > 3 * piece.facets.size();
  }

  /// Adds the chains of returns without facets along columns or rows.
  /// @param stride  from a return to the next: the number of columns, or 1
  void find_chains(std::size_t stride, std::vector<Piece>& pieces) {
    std::vector<uint8_t> used(alone_.size(), 0);
    for (std::size_t i = 0; i < alone_.size(); ++i) {
      if (alone_[i] == 0 || used[i] != 0) continue;
      Piece piece{{}, {static_cast<uint32_t>(i)}};
      for (std::size_t at = i;; at += stride) {
        used[at] = 1;
        const std::size_t next = at + stride;
        if (next >= alone_.size() || (stride == 1 && next % scene_.columns == 0)) break;
        if (alone_[next] == 0 || !is_near(at, next)) break;
        piece.chain.push_back(static_cast<uint32_t>(next));
      }
      if (piece.chain.size() < kChain) continue;
      for (const uint32_t link : piece.chain) joined_.join(piece.chain.front(), link);
      const auto mixed = std::count_if(piece.chain.begin(), piece.chain.end(),
                                       [this](uint32_t link) { return is_mixed(link); });
      if (2 * static_cast<std::size_t>(mixed) > piece.chain.size()) continue;
      for (const uint32_t link : piece.chain) alone_[link] = 0;
      piece.half_width_m = half_width_m(piece.chain, stride);
      pieces.push_back(std::move(piece));
    }
  }

  bool is_near(std::size_t a, std::size_t b) const {
    const Eigen::Vector3f before = scene_.points_m[a] - scene_.origins_m[a / scene_.columns];
    const Eigen::Vector3f after = scene_.points_m[b] - scene_.origins_m[b / scene_.columns];
    const float beside_m = before.normalized().cross(after).norm();
    const auto floor_m = static_cast<float>(options_.loose_floor_m);
    const float near_m = std::min(static_cast<float>(options_.max_loose_m),
                                  floor_m + static_cast<float>(options_.loose_factor) * beside_m);
    return (scene_.points_m[a] - scene_.points_m[b]).norm() <= near_m;
  }

  /// A quarter of the beams' distance across the chain: it is hit by one of them.
  float half_width_m(const std::vector<uint32_t>& chain, std::size_t stride) const {
    const uint32_t middle = chain[chain.size() / 2];
    const std::size_t across = stride == 1 ? scene_.columns : 1;
    for (const std::size_t other : {middle + across, middle - across}) {
      if (other >= scene_.points_m.size() || range_m(other) <= 0.0F) continue;
      if (scene_.kinds[other] == SmoothScene::Kind::none) continue;
      const Eigen::Vector3f own =
          scene_.points_m[middle] - scene_.origins_m[middle / scene_.columns];
      const Eigen::Vector3f beside =
          scene_.points_m[other] - scene_.origins_m[other / scene_.columns];
      return 0.25F * own.cross(beside.normalized()).norm();
    }
    return 0.25F * (scene_.points_m[chain[0]] - scene_.points_m[chain[1]]).norm();
  }

  bool is_mixed(uint32_t i) {
    const std::size_t row = i / scene_.columns, column = i % scene_.columns;
    return is_between(i, {column, scene_.columns - 1 - column}, 1) ||
           is_between(i, {row, scene_.rows - 1 - row}, static_cast<int64_t>(scene_.columns));
  }

  // Whether its range is between those of the first returns next to its piece, on both sides.
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
  const FacetOptions& options_;
  Islands joined_;
  std::vector<uint8_t> alone_;  ///< bare, and in no facet
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
    for (const Piece& piece : SceneFacets(scene, options, bare).pieces()) {
      pieces_.push_back({number, mesh_of(scene, piece)});
      for (const Triangle& facet : piece.facets) {
        for (const uint32_t i : facet) take(scene.points_m[i], scene.normals[i]);
      }
      for (const uint32_t i : piece.chain) take(scene.points_m[i], scene.normals[i]);
    }
  }

  /// Counts whether another scene sees the pieces or what is behind them.
  void look(std::size_t number, const ScenePoints& scene) {
    std::vector<std::array<int, 2>> beams(pieces_.size());  // that end there, that go through
    for (std::size_t row = 0; row < scene.rows; row += every_) {
      for (std::size_t column = 0; column < scene.columns; column += every_) {
        const std::size_t i = scene.index(row, column);
        if (scene.valid[i] != 0) follow(scene.origins_m[row], scene.points_m[i], beams);
      }
    }
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      const auto [ended, through] = beams[k];
      if (pieces_[k].scene == number) continue;
      if (through >= kBeams && ended * kBeams < through) ++pieces_[k].absent;
      if (ended >= kBeams) ++pieces_[k].present;
    }
  }

  void write(TriangleMesh& mesh) const {
    for (const Found& piece : pieces_) {
      if (piece.absent < piece.present) append_mesh(mesh, piece.mesh);
    }
  }

 private:
  static constexpr int kBeams = 3;  ///< fewer may be errors of poses
  static constexpr float kBehind =
      2.0F;  ///< a beam that ends this many voxels farther went through
  struct Found {
    std::size_t scene;
    TriangleMesh mesh;
    int present = 1;  ///< scenes that see it, its own among them
    int absent = 0;   ///< scenes that see what is behind it
  };
  struct Voxel {
    std::size_t piece = 0;                             ///< 1 more than its index
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< sum
  };

  static TriangleMesh mesh_of(const SmoothScene& scene, const Piece& piece) {
    TriangleMesh mesh;
    write_chain(scene, piece, mesh);
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
    return mesh;
  }

  /// A strip that faces the laser.
  static void write_chain(const SmoothScene& scene, const Piece& piece, TriangleMesh& mesh) {
    for (std::size_t i = 0; i < piece.chain.size(); ++i) {
      const uint32_t link = piece.chain[i];
      const uint32_t before = piece.chain[i == 0 ? 0 : i - 1];
      const uint32_t after = piece.chain[std::min(i + 1, piece.chain.size() - 1)];
      const Eigen::Vector3f along = scene.points_m[after] - scene.points_m[before];
      const Eigen::Vector3f aside =
          piece.half_width_m * along.cross(scene.normals[link]).normalized();
      const auto next = static_cast<uint32_t>(mesh.vertices_m.size());
      for (const float side : {1.0F, -1.0F}) {
        mesh.vertices_m.push_back(scene.points_m[link] + side * aside);
        mesh.normals.push_back(scene.normals[link]);
      }
      if (i == 0) continue;
      mesh.triangles.push_back({next - 2, next, next - 1});
      mesh.triangles.push_back({next - 1, next, next + 1});
    }
  }

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

void add_small_pieces(const PlacedScenes& placed,
                      const SmoothScenes& smoothed,
                      const SurfaceOptions& options,
                      TriangleMesh& mesh) {
  const NearMesh is_near(mesh, options.voxel_m);
  SmallPieces pieces(options);
  for (std::size_t number = 0; number < smoothed.count; ++number) {
    const SmoothScene scene = smoothed.at(number);
    std::vector<uint8_t> bare(scene.points_m.size(), 0);
    for (std::size_t i = 0; i < bare.size(); ++i) {
      bare[i] = scene.kinds[i] != SmoothScene::Kind::none && !is_near(scene.points_m[i]);
    }
    pieces.add(number, scene, std::move(bare), options.facets);
  }
  for (std::size_t number = 0; number < placed.count; ++number) {
    pieces.look(number, placed.at(number));
  }
  pieces.write(mesh);
}

}  // namespace marco::mapping3d
