#include "mapping3d/surface/simplify.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

#include "mapping3d/surface/collapsing_mesh.hpp"
#include "mapping3d/surface/laid_on_planes.hpp"
#include "mapping3d/surface/quadric.hpp"
#include "mapping3d/surface/surface_bound.hpp"
#include "mapping3d/surface/welded.hpp"

namespace marco::mapping3d {
namespace {

using Triangle = CollapsingMesh::Triangle;
using Corners = std::array<Eigen::Vector3f, 3>;

// The distance may be a little larger between samples.
constexpr double kBetweenSamples = 0.9;
// Part of the bound that the mean error of a move may be: so that few samples come near the bound.
constexpr double kMeanShare = 0.4;
// A move may turn a triangle by 75 degrees; more would fold the surface.
constexpr float kMinCosineOfTurn = 0.25F;
// Triangles of less, doubled, have no direction.
constexpr float kNoAreaM2 = 1e-9F;
// Borders weigh as planes across the surface, of the square of their edges' length.
constexpr float kBorderWeight = 1.0F;
// Where a move costs nothing, on a plane, short edges go first, else slivers are left, and vertices
// that stand for little, so that each sample changes its triangle a few times only.
constexpr double kSizeShare = 1e-6;
// Planes are thinned by rounds while more of their vertices move than this part.
constexpr double kFewMoves = 0.01;
// What back_m is measured with: a small part of the samples that were looked at before.
constexpr float kReportM2 = 1e-3F;

bool has(const Triangle& triangle, uint32_t vertex) {
  return std::find(triangle.begin(), triangle.end(), vertex) != triangle.end();
}

bool is_turned(const Corners& before, const Corners& after) {
  const Eigen::Vector3f was = (before[1] - before[0]).cross(before[2] - before[0]);
  const Eigen::Vector3f is = (after[1] - after[0]).cross(after[2] - after[0]);
  if (was.norm() < kNoAreaM2) return false;
  return is.norm() < kNoAreaM2 || was.dot(is) < kMinCosineOfTurn * was.norm() * is.norm();
}

class Simplifier {
 public:
  /// @param mesh  welded; outlives this
  Simplifier(const TriangleMesh& mesh,
             const std::vector<SurfacePlane>& planes,
             const SimplifyOptions& options)
      : mesh_(mesh),
        max_cost_m2_(std::pow(kMeanShare * options.max_error_m, 2)),
        laid_(laid_on_planes(mesh, planes, options.snap_share * options.max_error_m)),
        left_(welded(mesh.triangles, laid_.vertices_m), mesh.vertices_m.size()),
        bound_(mesh,
               snapped_m(),
               on_plane(),
               static_cast<float>(kBetweenSamples * options.max_error_m),
               static_cast<float>(options.sample_m2)),
        quadrics_(mesh.vertices_m.size()),
        queued_(mesh.vertices_m.size(), kNotQueued) {
    add_quadrics();
  }

  void run() {
    thin_planes();
    for (uint32_t i = 0; i < queued_.size(); ++i) {
      find_moves(i);
      if (!moves_.empty()) enqueue(key(moves_.front().cost_m2, i));
    }
    while (!queue_.empty()) {
      const uint64_t next = queue_.top();
      queue_.pop();
      const auto vertex = static_cast<uint32_t>(next);
      if (next != queued_[vertex]) continue;
      queued_[vertex] = kNotQueued;
      find_moves(vertex);
      if (moves_.empty()) continue;
      // It may have become dearer since.
      const uint64_t now = key(moves_.front().cost_m2, vertex);
      if (now > next && !queue_.empty() && now > queue_.top()) {
        enqueue(now);
        continue;
      }
      for (const Move& move : moves_) {
        if (try_move(vertex, move.onto)) break;
      }
    }
  }

  Simplified result() const {
    Simplified result;
    std::vector<uint32_t> numbers(mesh_.vertices_m.size(), kNew);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (left_.is_gone(t)) continue;
      Triangle triangle = left_.triangles()[t];
      for (uint32_t& corner : triangle) corner = numbered(corner, numbers, result.mesh);
      result.mesh.triangles.push_back(triangle);
    }
    result.there_m =
        bound_.largest_m([this](std::size_t t) { return corners_m(left_.triangles()[t]); });
    result.back_m = gap(result.mesh, bound_.to_original(), kReportM2).max_m;
    return result;
  }

 private:
  static constexpr uint32_t kNew = std::numeric_limits<uint32_t>::max();
  static constexpr uint64_t kNotQueued = std::numeric_limits<uint64_t>::max();
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  struct Move {
    double cost_m2;
    uint32_t onto;
  };

  // The cheapest first, to a fifth, then by number: those are adjacent in memory.
  static uint64_t key(double cost_m2, uint32_t vertex) {
    constexpr uint32_t kDropped = 21;  // leaves two binary digits of the mantissa
    const auto cost = static_cast<float>(cost_m2);
    uint32_t bits = 0;
    std::memcpy(&bits, &cost, sizeof bits);
    return uint64_t{bits >> kDropped} << 32U | vertex;
  }

  // How far snapping moved each triangle at most; less than 0 where it has no area any more.
  std::vector<float> snapped_m() const {
    std::vector<float> off_m(mesh_.triangles.size(), -1.0F);
    for (std::size_t t = 0; t < off_m.size(); ++t) {
      if (left_.is_gone(t)) continue;
      for (const uint32_t corner : mesh_.triangles[t]) {
        const float moved_m = (laid_.vertices_m[corner] - mesh_.vertices_m[corner]).norm();
        off_m[t] = std::max(off_m[t], moved_m);
      }
    }
    return off_m;
  }

  std::vector<uint8_t> on_plane() const {
    std::vector<uint8_t> all(mesh_.triangles.size(), 0);
    for (std::size_t t = 0; t < all.size(); ++t) {
      if (left_.is_gone(t)) continue;
      VertexPlanes common = laid_.planes[left_.triangles()[t][0]];
      for (const uint32_t corner : left_.triangles()[t]) common.keep(laid_.planes[corner]);
      all[t] = common.count() > 0 ? 1 : 0;
    }
    return all;
  }

  Corners corners_m(const Triangle& triangle) const {
    const auto& at_m = laid_.vertices_m;
    return {at_m[triangle[0]], at_m[triangle[1]], at_m[triangle[2]]};
  }

  uint32_t numbered(uint32_t vertex, std::vector<uint32_t>& numbers, TriangleMesh& to) const {
    if (numbers[vertex] == kNew) {
      numbers[vertex] = static_cast<uint32_t>(to.vertices_m.size());
      to.vertices_m.push_back(laid_.vertices_m[vertex]);
      if (!mesh_.normals.empty()) to.normals.push_back(mesh_.normals[vertex]);
      if (!mesh_.colors_rgb.empty()) to.colors_rgb.push_back(mesh_.colors_rgb[vertex]);
    }
    return numbers[vertex];
  }

  void add_quadrics() {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (left_.is_gone(t)) continue;
      const Triangle& triangle = left_.triangles()[t];
      const auto& [a, b, c] = corners_m(triangle);
      const Eigen::Vector3d cross = (b - a).cast<double>().cross((c - a).cast<double>());
      const Eigen::Vector3f normal = cross.normalized().cast<float>();
      const auto area_m2 = static_cast<float>(0.5 * cross.norm());
      for (const uint32_t corner : triangle) {
        quadrics_[corner].add(normal, a - laid_.vertices_m[corner], area_m2);
      }
      for (std::size_t side = 0; side < 3; ++side) {
        const uint32_t from = triangle[side], to = triangle[(side + 1) % 3];
        if (left_.triangles_between(from, to) == 1) add_border(from, to, normal);
      }
    }
  }

  void add_border(uint32_t from, uint32_t to, const Eigen::Vector3f& normal) {
    const Eigen::Vector3f edge = laid_.vertices_m[to] - laid_.vertices_m[from];
    const Eigen::Vector3f across = edge.cross(normal).normalized();
    for (const uint32_t corner : {from, to}) {
      // A border through both: each has the origin of its quadric.
      quadrics_[corner].add(across, Eigen::Vector3f::Zero(), kBorderWeight * edge.squaredNorm());
    }
  }

  // Of a move; kNever if it must not be made.
  double cost_m2(uint32_t vertex, uint32_t onto) const {
    if (!laid_.planes[vertex].are_all_of(laid_.planes[onto])) return kNever;
    const Eigen::Vector3f move_m = laid_.vertices_m[onto] - laid_.vertices_m[vertex];
    const double error_m2 =
        quadrics_[vertex].mean_with(quadrics_[onto], move_m, Eigen::Vector3f::Zero());
    if (!(error_m2 < max_cost_m2_)) return kNever;
    const auto length_m2 = static_cast<double>(move_m.squaredNorm());
    return error_m2 + kSizeShare * (length_m2 + quadrics_[vertex].weight());
  }

  // Those of a vertex, the cheapest first.
  void find_moves(uint32_t vertex) {
    moves_.clear();
    if (!left_.can_ever_move(vertex)) return;
    left_.neighbours(vertex, ring_);
    for (const uint32_t onto : ring_) {
      const double cost = cost_m2(vertex, onto);
      if (cost < kNever) moves_.push_back({cost, onto});
    }
    std::sort(moves_.begin(), moves_.end(), [](const Move& a, const Move& b) {
      return a.cost_m2 != b.cost_m2 ? a.cost_m2 < b.cost_m2 : a.onto < b.onto;
    });
  }

  void enqueue(uint64_t key) {
    uint64_t& queued = queued_[static_cast<uint32_t>(key)];
    if (key >= queued) return;
    queued = key;
    queue_.push(key);
  }

  // Within a plane a move costs nothing and needs no queue: in each round vertices move onto their
  // nearest neighbours, which stay for this round, so that edges grow alike everywhere.
  void thin_planes() {
    std::vector<uint32_t> inner;
    for (uint32_t i = 0; i < laid_.planes.size(); ++i) {
      if (laid_.planes[i].count() > 0 && left_.can_ever_move(i) && !left_.is_on_border(i)) {
        inner.push_back(i);
      }
    }
    std::vector<uint8_t> stays(laid_.planes.size(), 0);
    for (std::size_t moved = inner.size();
         static_cast<double>(moved) > kFewMoves * static_cast<double>(inner.size());) {
      moved = 0;
      std::erase_if(inner, [&](uint32_t vertex) {
        if (std::exchange(stays[vertex], uint8_t{0}) != 0) return false;
        const uint32_t onto = nearest_on_planes(vertex);
        if (onto == kNew) return true;
        if (!left_.can_move(vertex, onto) || !describe(vertex, onto)) return false;
        if (!step_.stays_on_plane || !bound_.allows(step_)) return true;
        take(vertex, onto);
        stays[onto] = 1;
        ++moved;
        return true;
      });
    }
  }

  // The nearest neighbour on all planes of a vertex, or kNew.
  uint32_t nearest_on_planes(uint32_t vertex) {
    left_.neighbours(vertex, ring_);
    uint32_t nearest = kNew;
    float least_m2 = std::numeric_limits<float>::infinity();
    for (const uint32_t other : ring_) {
      const float own_m2 = (laid_.vertices_m[other] - laid_.vertices_m[vertex]).squaredNorm();
      if (own_m2 >= least_m2 || !laid_.planes[vertex].are_all_of(laid_.planes[other])) continue;
      least_m2 = own_m2;
      nearest = other;
    }
    return nearest;
  }

  void take(uint32_t vertex, uint32_t onto) {
    bound_.take(step_);
    left_.move(vertex, onto);
    quadrics_[onto].add(quadrics_[vertex], laid_.vertices_m[vertex] - laid_.vertices_m[onto]);
  }

  bool try_move(uint32_t vertex, uint32_t onto) {
    if (!left_.can_move(vertex, onto) || !describe(vertex, onto)) return false;
    if (!bound_.allows(step_)) return false;
    left_.neighbours(vertex, ring_);
    take(vertex, onto);
    // What was refused may be possible now.
    for (const uint32_t near : ring_) {
      if (!left_.can_ever_move(near)) continue;
      const double cost = near == onto ? 0.0 : cost_m2(near, onto);
      if (cost < kNever) enqueue(key(cost, near));
    }
    return true;
  }

  // Fills `step_`. @returns false when it would turn a triangle.
  bool describe(uint32_t vertex, uint32_t onto) {
    step_.replaced.clear();
    step_.made.clear();
    step_.beside.clear();
    step_.vanishes_m = laid_.vertices_m[vertex];
    step_.fills_the_ring = !left_.is_on_border(vertex);
    bool turns = false;
    VertexPlanes common = laid_.planes[vertex];
    left_.for_each_triangle_of(vertex, [&](uint32_t t) {
      Triangle triangle = left_.triangles()[t];
      step_.replaced.push_back({t, corners_m(triangle)});
      for (const uint32_t corner : triangle) common.keep(laid_.planes[corner]);
      if (has(triangle, onto)) {
        add_beside(triangle, vertex, onto);
        return;
      }
      const Corners& before = step_.replaced.back().at_m;
      std::replace(triangle.begin(), triangle.end(), vertex, onto);
      step_.made.push_back({t, corners_m(triangle)});
      turns = turns || is_turned(before, step_.made.back().at_m);
    });
    step_.stays_on_plane = common.count() > 0;
    return !turns;
  }

  // What a vanishing triangle borders on, other than at the vertex.
  void add_beside(const Triangle& vanishing, uint32_t vertex, uint32_t onto) {
    left_.for_each_triangle_of(onto, [&](uint32_t t) {
      const Triangle& triangle = left_.triangles()[t];
      if (has(triangle, vertex)) return;
      for (const uint32_t corner : vanishing) {
        if (corner == onto || !has(triangle, corner)) continue;
        step_.beside.push_back({t, corners_m(triangle)});
      }
    });
  }

  const TriangleMesh& mesh_;
  double max_cost_m2_;
  LaidOnPlanes laid_;
  CollapsingMesh left_;
  SurfaceBound bound_;
  std::vector<Quadric> quadrics_;
  /// Of vertices: their place in the queue, which may also hold earlier ones.
  std::vector<uint64_t> queued_;
  std::priority_queue<uint64_t, std::vector<uint64_t>, std::greater<>> queue_;
  std::vector<uint32_t> ring_;
  std::vector<Move> moves_;
  SurfaceBound::Step step_;
};

}  // namespace

Simplified simplify(const TriangleMesh& mesh,
                    const std::vector<SurfacePlane>& planes,
                    const SimplifyOptions& options) {
  validate(options, "simplify");
  if (mesh.triangles.empty()) return {};
  const std::optional<TriangleMesh> one = welded(mesh);
  Simplifier simplifier(one ? *one : mesh, planes, options);
  simplifier.run();
  return simplifier.result();
}

}  // namespace marco::mapping3d
