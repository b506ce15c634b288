#include "mapping3d/point_tree.hpp"

#include <algorithm>
#include <limits>

namespace marco::mapping3d {
namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
constexpr std::size_t kLeafSize = 8;

}  // namespace

PointTree::PointTree(const std::vector<Eigen::Vector3f>& points_m) {
  nodes_.reserve(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    nodes_.push_back({points_m[i], static_cast<uint32_t>(i), 0});
  }
  build(0, nodes_.size());
}

void PointTree::build(std::size_t begin, std::size_t end) {
  if (end - begin <= kLeafSize) return;
  Eigen::Vector3f low = nodes_[begin].point_m, high = low;
  for (std::size_t i = begin + 1; i < end; ++i) {
    low = low.cwiseMin(nodes_[i].point_m);
    high = high.cwiseMax(nodes_[i].point_m);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [this](std::size_t i) { return nodes_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [axis](const Node& a, const Node& b) {
    return a.point_m[axis] < b.point_m[axis];
  });
  nodes_[middle].axis = static_cast<uint32_t>(axis);
  build(begin, middle);
  build(middle + 1, end);
}

std::optional<uint32_t> PointTree::nearest(const Eigen::Vector3f& query_m, float radius_m) const {
  Best best{radius_m * radius_m, kNone};
  search(0, nodes_.size(), query_m, best);
  if (best.index == kNone) return std::nullopt;
  return best.index;
}

void PointTree::search(std::size_t begin,
                       std::size_t end,
                       const Eigen::Vector3f& query_m,
                       Best& best) const {
  const auto consider = [&](const Node& node) {
    const float distance2_m2 = (node.point_m - query_m).squaredNorm();
    if (distance2_m2 < best.distance2_m2) best = {distance2_m2, node.index};
  };
  if (end - begin <= kLeafSize) {
    for (std::size_t i = begin; i < end; ++i) consider(nodes_[i]);
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const Node& root = nodes_[middle];
  const float beyond_m = query_m[root.axis] - root.point_m[root.axis];
  const bool below = beyond_m < 0.0F;
  below ? search(begin, middle, query_m, best) : search(middle + 1, end, query_m, best);
  consider(root);
  if (beyond_m * beyond_m >= best.distance2_m2) return;
  below ? search(middle + 1, end, query_m, best) : search(begin, middle, query_m, best);
}

}  // namespace marco::mapping3d
