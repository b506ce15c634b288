#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace marco::mapping3d {

/// Nearest-neighbour search among fixed points: a k-d tree (nanoflann). Const members are safe from
/// several threads.
class PointTree {
 public:
  /// @param points_m finite; may be empty.
  explicit PointTree(std::vector<Eigen::Vector3f> points_m);
  ~PointTree();
  PointTree(PointTree&&) noexcept;
  PointTree& operator=(PointTree&&) noexcept;

  /// Index of the point nearest to `query_m` and nearer than `radius_m`; nothing when there is
  /// none.
  std::optional<uint32_t> nearest(const Eigen::Vector3f& query_m, float radius_m) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace marco::mapping3d
