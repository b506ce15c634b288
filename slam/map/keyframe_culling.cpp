#include "slam/map/keyframe_culling.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace marco::slam {
namespace {

// Of path: keyframes less apart follow each other.
constexpr double kPassM = 8.0;
constexpr int kAtMost = 3;  // times keys_a_place
constexpr std::size_t kMatched = 8;

// A node takes over no more loops than make it so many: those of every visit would not end.
constexpr int kLoopsANode = 2;

// What a match cannot know of itself; and of a pose that no match confirms.
constexpr double kSigmaM = 0.01, kSigmaDeg = 0.15;
constexpr double kLooseSigmaM = 0.05, kLooseSigmaDeg = 1.0;

struct Older {
  int key;
  double apart;
};

std::vector<Older> of_one_place(const std::vector<Keyframe>& keys,
                                int key,
                                bool loop_closed,
                                const ThinningOptions& options) {
  const Keyframe& newer = keys[static_cast<std::size_t>(key)];
  const double turn_rad = deg_to_rad(options.near_turn_deg);
  std::vector<Older> found;
  for (int i = 0; i < key; ++i) {
    const Keyframe& older = keys[static_cast<std::size_t>(i)];
    const Pose2 moved = between(older.world_from_robot, newer.world_from_robot);
    const double panned_rad = normalize_angle(newer.sensor_heading_rad - older.sensor_heading_rad);
    const double apart =
        std::max({moved.translation_m().norm() / options.near_m,
                  std::abs(moved.theta_rad) / turn_rad, std::abs(panned_rad) / turn_rad});
    const bool same_pass = newer.path_m - older.path_m < kPassM;
    if (!same_pass && !loop_closed) continue;
    if (apart <= (same_pass ? 0.5 : 1.0)) found.push_back({i, apart});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Older& a, const Older& b) { return a.apart < b.apart; });
  return found;
}

Eigen::Matrix3d diagonal_covariance(double sigma_m, double sigma_deg) {
  const double sigma_rad = deg_to_rad(sigma_deg);
  return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
}

// What an error of (x, y, theta) in frame b is in frame a.
Eigen::Matrix3d carried(const Eigen::Matrix3d& covariance, const Pose2& a_from_b) {
  Eigen::Matrix3d carry = Eigen::Matrix3d::Identity();
  carry.topLeftCorner<2, 2>() = a_from_b.rotation();
  carry(0, 2) = a_from_b.y_m;
  carry(1, 2) = -a_from_b.x_m;
  return carry * covariance * carry.transpose();
}

// The edge seen from where the merged node is now; its error lives in the frame of `to`.
PoseGraphEdge moved_edge(PoseGraphEdge edge, int key, const MergedKeyframe& merged) {
  Eigen::Matrix3d covariance = edge.information.inverse();
  if (edge.from == key) {
    covariance += carried(merged.covariance, edge.from_from_to.inverse());
    edge.from_from_to = merged.into_from_key * edge.from_from_to;
    edge.from = merged.into;
  } else {
    covariance = carried(covariance + merged.covariance, merged.into_from_key);
    edge.from_from_to = edge.from_from_to * merged.into_from_key.inverse();
    edge.to = merged.into;
  }
  edge.information = covariance.inverse();
  return edge;
}

}  // namespace

std::optional<MergedKeyframe> seen_before(const std::vector<Keyframe>& keys,
                                          int key,
                                          bool loop_closed,
                                          const SurfelMatcher& matcher,
                                          const ThinningOptions& options) {
  const std::vector<Older> older = of_one_place(keys, key, loop_closed, options);
  if (static_cast<int>(older.size()) < options.keys_a_place) return std::nullopt;
  const Keyframe& newer = keys[static_cast<std::size_t>(key)];
  const Keyframe& nearest = keys[static_cast<std::size_t>(older.front().key)];
  SurfelPyramid place(matcher.options(), nearest.world_from_robot.translation_m());
  for (std::size_t i = 0; i < std::min(kMatched, older.size()); ++i) {
    const Keyframe& scan = keys[static_cast<std::size_t>(older[i].key)];
    place.add(scan.points_in_robot, scan.world_from_robot);
  }
  const SurfelMatch match =
      matcher.match(place, newer.points_in_robot, newer.world_from_robot, nullptr);
  const Pose2 moved = between(newer.world_from_robot, match.map_from_robot);
  if (match.status != SurfelMatch::Status::no_overlap && match.overlap >= options.min_overlap &&
      moved.translation_m().norm() <= options.max_shift_m &&
      std::abs(moved.theta_rad) <= deg_to_rad(options.max_turn_deg)) {
    const Eigen::Matrix3d world =
        (match.information + 1e-6 * Eigen::Matrix3d::Identity()).inverse();
    return MergedKeyframe{older.front().key,
                          between(nearest.world_from_robot, match.map_from_robot),
                          carried(world, Pose2{0, 0, -match.map_from_robot.theta_rad}) +
                              diagonal_covariance(kSigmaM, kSigmaDeg)};
  }
  if (static_cast<int>(older.size()) < kAtMost * options.keys_a_place) return std::nullopt;
  return MergedKeyframe{older.front().key,
                        between(nearest.world_from_robot, newer.world_from_robot),
                        diagonal_covariance(kLooseSigmaM, kLooseSigmaDeg)};
}

void merge_nodes(int key,
                 const MergedKeyframe& merged,
                 std::vector<PoseGraphEdge>& edges,
                 std::vector<Loop>& loops) {
  using Pair = std::tuple<int, int, bool>;
  const auto pair_of = [](const PoseGraphEdge& edge) {
    return Pair{std::min(edge.from, edge.to), std::max(edge.from, edge.to), edge.is_loop};
  };
  // Only pairs with the node that stays can come twice.
  std::set<Pair> known;
  int loops_there = 0;
  for (const PoseGraphEdge& edge : edges) {
    if (edge.from != merged.into && edge.to != merged.into) continue;
    known.insert(pair_of(edge));
    loops_there += edge.is_loop ? 1 : 0;
  }
  const auto renumbered = [key](int node) { return node > key ? node - 1 : node; };
  std::vector<PoseGraphEdge> kept_edges;
  std::vector<Loop> kept_loops;
  kept_edges.reserve(edges.size());
  std::size_t next_loop = 0;
  for (PoseGraphEdge edge : edges) {
    const std::size_t loop_at = edge.is_loop ? next_loop++ : 0;
    if (edge.from == key || edge.to == key) {
      edge = moved_edge(edge, key, merged);
      if (edge.from == edge.to || !known.insert(pair_of(edge)).second) continue;
      if (edge.is_loop && ++loops_there > kLoopsANode) continue;
    }
    edge.from = renumbered(edge.from);
    edge.to = renumbered(edge.to);
    if (edge.is_loop) {
      Loop loop = loops[loop_at];
      loop.from = edge.from;
      loop.to = edge.to;
      loop.from_from_to = edge.from_from_to;
      loop.information = edge.information;
      kept_loops.push_back(loop);
    }
    kept_edges.push_back(edge);
  }
  edges = std::move(kept_edges);
  loops = std::move(kept_loops);
}

}  // namespace marco::slam
