#include "mapping3d/point_tree.hpp"

#include <nanoflann.hpp>

namespace marco::mapping3d {

struct PointTree::Index {
  explicit Index(std::vector<Eigen::Vector3f> points)
      : points_m(std::move(points)), tree(3, *this) {}

  // What nanoflann asks of a set of points.
  std::size_t kdtree_get_point_count() const { return points_m.size(); }
  float kdtree_get_pt(std::size_t point, std::size_t axis) const {
    return points_m[point][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;  // it computes the box itself
  }

  using Metric = nanoflann::L2_Simple_Adaptor<float, Index>;
  std::vector<Eigen::Vector3f> points_m;
  nanoflann::KDTreeSingleIndexAdaptor<Metric, Index, 3, uint32_t> tree;
};

PointTree::PointTree(std::vector<Eigen::Vector3f> points_m)
    : index_(std::make_unique<Index>(std::move(points_m))) {}
PointTree::~PointTree() = default;
PointTree::PointTree(PointTree&&) noexcept = default;
PointTree& PointTree::operator=(PointTree&&) noexcept = default;

std::optional<uint32_t> PointTree::nearest(const Eigen::Vector3f& query_m, float radius_m) const {
  uint32_t nearest = 0;
  float distance2_m2 = 0.0F;
  nanoflann::KNNResultSet<float, uint32_t> found(1);
  found.init(&nearest, &distance2_m2);
  distance2_m2 = radius_m * radius_m;  // the worst that counts
  index_->tree.findNeighbors(found, query_m.data(), {});
  if (found.size() == 0) return std::nullopt;
  return nearest;
}

}  // namespace marco::mapping3d
