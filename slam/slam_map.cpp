// What Slam does with its keyframes: the local map, loops, and what becomes one.
#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/back_end/graph/ways.hpp"
#include "slam/slam.hpp"

namespace marco::slam {
namespace {

// Of path, to loops found before and after a keyframe that may become one with others.
constexpr double kClosedWithinM = 1.5;

// Looked at for each new one, so that no scan waits for many.
constexpr int kThinnedAtOnce = 3;

// Squared deviations (of 3 degrees of freedom) up to which a loop says what is believed anyway: 8
// mm, as a loop's own uncertainty is 2 cm. (At 0.5 a building of two equal wings loses loops.) Of a
// larger graph, whose optimization costs more, more is let pass: up to 2 cm.
double agreement_limit_chi2(std::size_t keyframes) {
  constexpr double kAgrees = 0.15, kLarge = 2500.0, kMost = 1.0;
  return std::min(kMost, kAgrees * std::max(1.0, static_cast<double>(keyframes) / kLarge));
}

// By which part more loops are known when the graph is optimized although they all agree.
constexpr double kGrowth = 0.1;

// Whether that many more have come. A function of the two numbers, so that nothing is to be kept.
bool grew(std::size_t before, std::size_t after) {
  const auto steps = [](std::size_t count) {
    return std::floor(std::log1p(static_cast<double>(count)) / std::log1p(kGrowth));
  };
  return steps(after) > steps(before);
}

std::size_t count_loops(const std::vector<PoseGraphEdge>& edges) {
  return static_cast<std::size_t>(
      std::count_if(edges.begin(), edges.end(), [](const auto& edge) { return edge.is_loop; }));
}

}  // namespace

void LoopWork::run() {
  const std::size_t known = count_loops(graph.edges());
  bool is_news = false;
  for (const LoopQuestion& question : questions) {
    if (const auto loop = closer.answer(question)) found.push_back(*loop);
  }
  for (const Loop& loop : found) {
    const PoseGraphEdge edge{loop.from, loop.to, loop.from_from_to, loop.information, true};
    is_news = is_news || graph.edge_chi2(edge) > agreement_limit_chi2(graph.poses().size());
    graph.add_edge(edge);
  }
  moved = doubt_loops || is_news || grew(known, known + found.size());
  if (doubt_loops) {
    edge_in_force = graph.optimize_robustly().edge_in_force;
  } else if (moved) {
    graph.optimize_roughly();
  }
}

int Slam::first_local() const {
  const int ever = static_cast<int>(keys_.size()) + merged_keys_;
  const int beyond = ever - options_.window_keyframes;
  const int step = options_.window_slack + 1;
  return std::max(0, beyond) / step * step;
}

void Slam::extend_local_map() {
  likelihood_.reset();
  if (!local_map_ || first_local() != local_map_first_) {
    rebuild_local_map();
  } else {
    local_map_->add(keys_.back().points_in_robot, keys_.back().world_from_robot);
  }
}

void Slam::rebuild_local_map() {
  // In the middle of what the map will cover, whenever it is made.
  const int middle = std::min(static_cast<int>(keys_.size()) - 1,
                              first_local_key() + options_.window_keyframes - 1);
  rebuild_local_map(keys_[static_cast<std::size_t>(middle)].world_from_robot.translation_m());
}

void Slam::rebuild_local_map(const Eigen::Vector2d& centre_m) {
  const int first = first_local_key(), count = static_cast<int>(keys_.size());
  likelihood_.reset();
  local_map_first_ = first_local();
  if (!local_map_) local_map_.emplace(options_.fine, centre_m);
  local_map_->restart(centre_m);
  for (int key = first; key < count; ++key) {
    const Keyframe& scan = keys_[static_cast<std::size_t>(key)];
    local_map_->add(scan.points_in_robot, scan.world_from_robot);
  }
}

bool Slam::look_for_loops() {
  const double path_m = keys_.back().path_m;
  if (work_is_out_ || path_m - last_search_path_m_ < options_.loops.attempt_every_m) return false;
  last_search_path_m_ = path_m;
  const int count = static_cast<int>(keys_.size());
  const std::vector<double> ways = ways_m(count - 1, count, graph_.edges());
  LoopWork work{loop_closer_, loop_closer_.questions(keys_, closed_path_m_, ways), graph_, path_m};
  work.doubt_loops = thinning_is_due();
  if (work.questions.empty() && !work.doubt_loops) return false;
  work_is_out_ = true;
  if (deferred_) {
    work_ = std::move(work);
    return false;
  }
  work.run();
  return accept(work);
}

std::optional<LoopWork> Slam::take_loop_work() { return std::exchange(work_, std::nullopt); }

bool Slam::accept(const LoopWork& work) {
  const std::vector<Pose2>& optimized = work.graph.poses();
  if (!work_is_out_ || work_ || optimized.size() > keys_.size()) return false;
  work_is_out_ = false;
  if (work.found.empty() && !work.doubt_loops) return false;
  if (!work.found.empty()) {
    closed_path_m_ = work.path_m;
    closings_m_.push_back(work.path_m);
  }
  for (const Loop& loop : work.found) {
    loops_.push_back(loop);
    graph_.add_edge({loop.from, loop.to, loop.from_from_to, loop.information, true});
  }
  if (!work.moved) return false;
  const std::size_t known = optimized.size();
  const Pose2 new_from_old = optimized.back() * keys_[known - 1].world_from_robot.inverse();
  std::vector<Pose2> poses = optimized;
  for (std::size_t key = known; key < keys_.size(); ++key) {
    poses.push_back(new_from_old * keys_[key].world_from_robot);
  }
  for (std::size_t key = 0; key < poses.size(); ++key) {
    graph_.set_pose(static_cast<int>(key), poses[key]);
  }
  if (work.doubt_loops) {
    forget_wrong_loops(work);
    thin_until_ = std::max(looked_at_, static_cast<int>(known) - options_.thinning.recent_keys);
  }
  move_keys(poses);
  return true;
}

void Slam::forget_wrong_loops(const LoopWork& work) {
  // Edges that came meanwhile stand between those that were doubted and the loops found.
  const std::size_t doubted = work.edge_in_force.size() - work.found.size();
  const std::vector<PoseGraphEdge> edges = graph_.edges();
  const std::size_t first_found = edges.size() - work.found.size();
  std::vector<PoseGraphEdge> kept_edges;
  std::vector<Loop> kept_loops;
  for (std::size_t edge = 0, loop = 0; edge < edges.size(); ++edge) {
    bool right = true;
    if (edge < doubted) right = work.edge_in_force[edge];
    if (edge >= first_found) right = work.edge_in_force[doubted + edge - first_found];
    if (right) kept_edges.push_back(edges[edge]);
    if (right && edges[edge].is_loop) kept_loops.push_back(loops_[loop]);
    if (edges[edge].is_loop) ++loop;
  }
  loops_ = std::move(kept_loops);
  remake_graph(kept_edges);
}

void Slam::remake_graph(const std::vector<PoseGraphEdge>& edges) {
  const std::vector<Pose2> poses = graph_.poses();
  graph_ = PoseGraph(options_.graph);
  for (const Pose2& pose : poses) graph_.add_node(pose);
  for (const PoseGraphEdge& edge : edges) graph_.add_edge(edge);
}

bool Slam::thinning_is_due() const {
  return looked_at_ >= thin_until_ &&
         static_cast<int>(keys_.size()) >= kept_keys_ + options_.thinning.after_keys;
}

void Slam::thin_keys() {
  // What is being worked on elsewhere keeps its numbers.
  if (work_is_out_ || looked_at_ >= thin_until_) return;
  for (int i = 0; i < kThinnedAtOnce && looked_at_ < thin_until_; ++i) {
    if (merge_into_older(looked_at_)) {
      --thin_until_;
    } else {
      ++looked_at_;
    }
  }
  if (looked_at_ >= thin_until_) kept_keys_ = looked_at_;
}

bool Slam::is_closed_around(double path_m) const {
  const auto within = [path_m](double from_m, double to_m) {
    return [=](double at_m) { return at_m >= path_m + from_m && at_m <= path_m + to_m; };
  };
  return std::any_of(closings_m_.begin(), closings_m_.end(), within(-kClosedWithinM, 0.0)) &&
         std::any_of(closings_m_.begin(), closings_m_.end(), within(0.0, kClosedWithinM));
}

bool Slam::merge_into_older(int key) {
  const double path_m = keys_[static_cast<std::size_t>(key)].path_m;
  std::erase_if(closings_m_, [path_m](double at_m) { return at_m < path_m - kClosedWithinM; });
  const auto merged =
      seen_before(keys_, key, is_closed_around(path_m), matcher_, options_.thinning);
  if (!merged) return false;
  std::vector<PoseGraphEdge> edges = graph_.edges();
  merge_nodes(key, *merged, edges, loops_);
  forget_scans_of(key);
  rehang_scans(key, *merged);
  keys_.erase(keys_.begin() + key);
  likelihood_.reset();
  ++merged_keys_;
  graph_.remove_node(key);
  remake_graph(edges);
  thin_trail();
  return true;
}

void Slam::move_keys(const std::vector<Pose2>& world_from_keys) {
  const Pose2 key_from_robot = between(keys_.back().world_from_robot, world_from_robot_);
  for (std::size_t key = 0; key < keys_.size(); ++key) {
    keys_[key].world_from_robot = world_from_keys[key];
  }
  world_from_robot_ = keys_.back().world_from_robot * key_from_robot;
  ++revision_;
  standing_.reset();
  rebuild_local_map();
}

void Slam::finish() {
  if (keys_.size() < 2) return;
  const PoseGraphResult result = graph_.optimize_robustly();
  std::vector<PoseGraphEdge> edges;
  for (std::size_t edge = 0, loop = 0; edge < graph_.edges().size(); ++edge) {
    if (graph_.edges()[edge].is_loop) loops_[loop++].in_force = result.edge_in_force[edge];
    if (result.edge_in_force[edge]) edges.push_back(graph_.edges()[edge]);
  }
  std::vector<OrientedScan> scans;
  for (const Keyframe& key : keys_) scans.push_back(only_oriented(key.points_in_robot));
  std::vector<Pose2> poses = graph_.poses();
  refined_ = refine_jointly(scans, edges, options_.refinement, poses);
  for (std::size_t key = 0; key < poses.size(); ++key) {
    graph_.set_pose(static_cast<int>(key), poses[key]);
  }
  move_keys(poses);
}

OrientedScan Slam::only_oriented(const OrientedPoints& points) {
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

}  // namespace marco::slam
