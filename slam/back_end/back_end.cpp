#include "slam/back_end/back_end.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "lcm_tools/base/check.hpp"
#include "slam/back_end/graph/joint_refinement.hpp"
#include "slam/back_end/graph/relative_covariance.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::slam {
namespace {

// Of path, to the loop closings before and after a keyframe.
constexpr double kClosedWithinM = 1.5;

// Maps of earlier versions may hold information matrices with a negative eigenvalue: what is
// claimed of that direction is forgotten.
void repair(BackEndState& state) {
  for (PoseGraphEdge& edge : state.edges) edge.information = semidefinite_part(edge.information);
}

OrientedScan only_oriented(const OrientedPoints& points) {
  OrientedScan scan{Points2(2, points.points.cols()), Points2(2, points.points.cols())};
  Eigen::Index used = 0;
  for (Eigen::Index i = 0; i < points.points.cols(); ++i) {
    if (!points.has_normal(i)) continue;
    scan.points_in_robot.col(used) = points.points.col(i);
    scan.normals_in_robot.col(used++) = points.normals.col(i);
  }
  scan.points_in_robot.conservativeResize(2, used);
  scan.normals_in_robot.conservativeResize(2, used);
  return scan;
}

// refine_jointly() over the keyframes' points that lie on something smooth, with its reach adapted
// to the noise of their ranges. @pre there is a keyframe, and one pose for each.
JointRefinementResult refine_keyframes(const std::vector<Keyframe>& keys,
                                       const std::vector<PoseGraphEdge>& edges,
                                       const JointRefinementOptions& options,
                                       std::vector<Pose2>& poses) {
  std::vector<OrientedScan> scans;
  scans.reserve(keys.size());
  for (const Keyframe& key : keys) scans.push_back(only_oriented(key.points_in_robot));
  return refine_jointly(scans, edges, adapted(options, keys.back().points_in_robot.range_sigma_m),
                        poses);
}

}  // namespace

void check(const BackEndState& state, const KeyframeSet& keyframes) {
  const std::size_t count = keyframes.keys.size();
  std::size_t loop_edges = 0;
  for (const PoseGraphEdge& edge : state.edges) {
    require(is_index(edge.from, count) && is_index(edge.to, count) && edge.from != edge.to,
            "an edge of the graph ends at no keyframe");
    require(is_near(edge.from_from_to), "an edge of the graph is longer than 1000 km");
    loop_edges += edge.is_loop ? 1 : 0;
  }
  require(state.loops.size() == loop_edges, "the number of loops differs from that of loop edges");
  for (const Loop& loop : state.loops) {
    require(is_index(loop.from, count) && is_index(loop.to, count), "a loop ends at no keyframe");
    require(is_near(loop.from_from_to) && is_near(loop.believed), "a loop is longer than 1000 km");
  }
}

BackEnd::BackEnd(const LoopCloser& loop_closer,
                 const PoseGraphOptions& graph,
                 const JointRefinementOptions& refinement)
    : loop_closer_(loop_closer), graph_options_(graph), refinement_options_(refinement) {}

void BackEnd::restore(const BackEndState& state) {
  state_ = state;
  repair(state_);
  work_.reset();
  work_is_out_ = false;
}

void BackEnd::add_loop(const Loop& loop) {
  state_.loops.push_back(loop);
  state_.edges.push_back(loop.edge());
}

void BackEnd::append(const BackEndState& session, int first_key) {
  for (PoseGraphEdge edge : session.edges) {
    edge.from += first_key;
    edge.to += first_key;
    state_.edges.push_back(edge);
  }
  repair(state_);
  for (Loop loop : session.loops) {
    loop.from += first_key;
    loop.to += first_key;
    state_.loops.push_back(loop);
  }
}

PoseGraph BackEnd::graph_of(const std::vector<Keyframe>& keys) const {
  PoseGraph graph(graph_options_);
  for (const Keyframe& key : keys) graph.add_node(key.world_from_robot);
  for (const PoseGraphEdge& edge : state_.edges) graph.add_edge(edge);
  return graph;
}

bool BackEnd::prepare_work(const std::vector<Keyframe>& keys, bool robust) {
  const double path_m = keys.back().path_m;
  if (work_is_out_ || path_m < state_.next_search_path_m) return false;
  state_.next_search_path_m = path_m + loop_closer_.options().attempt_every_m;
  std::vector<LoopCandidate> candidates;
  if (loop_closer_.may_have_candidates(keys)) {
    candidates = loop_closer_.candidates(keys, uncertainties_of_newest(keys), state_.closed_path_m);
    std::erase_if(candidates, [&](const LoopCandidate& loop) {
      return forbids(edits_, keys[static_cast<std::size_t>(loop.from)].utime,
                     keys[static_cast<std::size_t>(loop.to)].utime);
    });
    // A wide search takes long, and there is time for it: the revisit will last.
    constexpr double kEveryPart = 0.25;
    for (const LoopCandidate& candidate : candidates) {
      state_.next_search_path_m =
          std::max(state_.next_search_path_m,
                   path_m + kEveryPart * loop_closer_.shift_m(candidate.covariance));
    }
  }
  if (candidates.empty() && !robust) return false;
  work_ = LoopWork{loop_closer_, std::move(candidates), graph_of(keys), path_m, robust};
  work_is_out_ = true;
  return true;
}

std::vector<RelativeUncertainty> BackEnd::uncertainties_of_newest(
    const std::vector<Keyframe>& keys) const {
  std::vector<Pose2> poses;
  poses.reserve(keys.size());
  for (const Keyframe& key : keys) poses.push_back(key.world_from_robot);
  return relative_uncertainties(static_cast<int>(keys.size()) - 1, poses, state_.edges,
                                loop_closer_.max_variance_m2());
}

std::optional<LoopWork> BackEnd::take_work() { return std::exchange(work_, std::nullopt); }

std::optional<std::vector<Pose2>> BackEnd::accept(const LoopWork& work,
                                                  const std::vector<Keyframe>& keys) {
  std::vector<Pose2> poses = work.graph.poses();
  const std::size_t known = poses.size();
  if (!work_is_out_ || work_ || known > keys.size()) return std::nullopt;
  work_is_out_ = false;
  if (!work.found.empty()) {
    state_.closed_path_m = work.path_m;
    state_.loop_closings_m.push_back(work.path_m);
  }
  for (const Loop& loop : work.found) add_loop(loop);
  if (!work.moved) return std::nullopt;
  const Pose2 new_from_old = poses.back() * keys[known - 1].world_from_robot.inverse();
  for (std::size_t key = known; key < keys.size(); ++key) {
    poses.push_back(new_from_old * keys[key].world_from_robot);
  }
  if (work.robust) remove_outliers(work);
  return poses;
}

void BackEnd::remove_outliers(const LoopWork& work) {
  // Edges that came meanwhile stand between those that were examined and the loops found.
  const std::size_t examined = work.edge_is_inlier.size() - work.found.size();
  const std::size_t first_found = state_.edges.size() - work.found.size();
  keep_edges([&](std::size_t edge) {
    if (edge < examined) return static_cast<bool>(work.edge_is_inlier[edge]);
    return edge < first_found || work.edge_is_inlier[examined + edge - first_found];
  });
}

void BackEnd::remove_loops(const MapEdits& edits, const std::vector<Keyframe>& keys) {
  keep_edges([&](std::size_t index) {
    const PoseGraphEdge& edge = state_.edges[index];
    return !edge.is_loop || !forbids(edits, keys[static_cast<std::size_t>(edge.from)].utime,
                                     keys[static_cast<std::size_t>(edge.to)].utime);
  });
}

void BackEnd::keep_edges(const std::function<bool(std::size_t)>& is_kept) {
  std::vector<PoseGraphEdge> kept_edges;
  std::vector<Loop> kept_loops;
  for (std::size_t edge = 0, loop = 0; edge < state_.edges.size(); ++edge) {
    const bool is_loop = state_.edges[edge].is_loop;
    if (is_kept(edge)) {
      kept_edges.push_back(state_.edges[edge]);
      if (is_loop) kept_loops.push_back(state_.loops[loop]);
    }
    if (is_loop) ++loop;
  }
  state_.loops = std::move(kept_loops);
  state_.edges = std::move(kept_edges);
}

bool BackEnd::has_loops_around(double path_m) {
  std::vector<double>& closings_m = state_.loop_closings_m;
  std::erase_if(closings_m, [path_m](double at_m) { return at_m < path_m - kClosedWithinM; });
  const auto within = [path_m](double from_m, double to_m) {
    return [=](double at_m) { return at_m >= path_m + from_m && at_m <= path_m + to_m; };
  };
  return std::any_of(closings_m.begin(), closings_m.end(), within(-kClosedWithinM, 0.0)) &&
         std::any_of(closings_m.begin(), closings_m.end(), within(0.0, kClosedWithinM));
}

void BackEnd::merge_node(int key, const MergedKeyframe& merged) {
  merge_nodes(key, merged, state_.edges, state_.loops);
}

std::vector<Pose2> BackEnd::optimized(const std::vector<Keyframe>& keys) const {
  PoseGraph graph = graph_of(keys);
  graph.optimize();
  return graph.poses();
}

std::vector<Pose2> BackEnd::finish(const std::vector<Keyframe>& keys,
                                   JointRefinementResult& refined) {
  PoseGraph graph = graph_of(keys);
  const PoseGraphResult result = graph.optimize_robustly();
  std::vector<PoseGraphEdge> inliers;
  for (std::size_t edge = 0, loop = 0; edge < state_.edges.size(); ++edge) {
    if (state_.edges[edge].is_loop) state_.loops[loop++].is_inlier = result.edge_is_inlier[edge];
    if (result.edge_is_inlier[edge]) inliers.push_back(state_.edges[edge]);
  }
  std::vector<Pose2> poses = graph.poses();
  refined = refine_keyframes(keys, inliers, refinement_options_, poses);
  return poses;
}

}  // namespace marco::slam
