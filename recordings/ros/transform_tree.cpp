#include "recordings/ros/transform_tree.hpp"

#include <algorithm>

namespace marco::ros {

void TransformTree::add(const TransformMessage& transform, bool is_static) {
  const std::string& parent = transform.header.frame_id;
  const std::string& child = transform.child_frame_id;
  const Pose3& pose = transform.parent_from_child;
  if (parent.empty() || child.empty() || parent == child || !pose.translation().allFinite()) return;
  constexpr std::size_t kMostEdges = 10'000;
  const std::pair frames(child, parent);
  if (edges_.size() == kMostEdges && !edges_.contains(frames)) return;
  FrameEdge& edge = edges_[frames];
  if (edge.count == 0 || is_static) {
    edge.parent = parent;
    edge.child = child;
    edge.parent_from_child = pose;
  }
  edge.is_static = edge.is_static || is_static;
  ++edge.count;
  const Pose3 moved = edge.parent_from_child.inverse() * pose;
  edge.moved_m = std::max(edge.moved_m, moved.translation().norm());
  edge.turned_rad = std::max(edge.turned_rad, Eigen::AngleAxisd(moved.linear()).angle());
}

const FrameEdge* TransformTree::above(const std::string& child) const {
  const FrameEdge* best = nullptr;
  const auto is_better = [](const FrameEdge& a, const FrameEdge& b) {
    return a.moves() != b.moves() ? b.moves() : a.count > b.count;
  };
  for (auto it = edges_.lower_bound({child, ""}); it != edges_.end() && it->first.first == child;
       ++it) {
    if (best == nullptr || is_better(it->second, *best)) best = &it->second;
  }
  return best;
}

bool TransformTree::contains(const std::string& frame) const {
  return std::any_of(edges_.begin(), edges_.end(), [&](const auto& edge) {
    return edge.second.child == frame || edge.second.parent == frame;
  });
}

std::vector<const FrameEdge*> TransformTree::way_up(const std::string& frame) const {
  std::vector<const FrameEdge*> way;
  for (const FrameEdge* edge = above(frame); edge != nullptr; edge = above(edge->parent)) {
    const bool is_round = std::find(way.begin(), way.end(), edge) != way.end();
    if (is_round) break;
    way.push_back(edge);
  }
  return way;
}

std::optional<Pose3> TransformTree::fixed_pose(const std::string& in,
                                               const std::string& frame) const {
  // From each frame on the way up to `frame`'s pose in it, as far as nothing moves.
  const auto poses_up = [this](const std::string& from) {
    std::map<std::string, Pose3> poses{{from, Pose3::Identity()}};
    Pose3 pose = Pose3::Identity();
    for (const FrameEdge* edge : way_up(from)) {
      if (edge->moves()) break;
      pose = edge->parent_from_child * pose;
      poses.emplace(edge->parent, pose);
    }
    return poses;
  };
  const auto of_frame = poses_up(frame), of_in = poses_up(in);
  for (const auto& [ancestor, pose] : of_frame) {
    if (const auto other = of_in.find(ancestor); other != of_in.end()) {
      return other->second.inverse() * pose;
    }
  }
  return std::nullopt;
}

std::vector<const FrameEdge*> TransformTree::edges() const {
  std::vector<const FrameEdge*> edges;
  for (const auto& [frames, edge] : edges_) edges.push_back(&edge);
  return edges;
}

}  // namespace marco::ros
