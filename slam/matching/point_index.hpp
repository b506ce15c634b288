#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/pose2.hpp"

namespace marco::slam {

/// Nearest neighbours among fixed points of the plane: a flat grid of buckets, searched ring by
/// ring. Owns a copy of the points. Const members are safe from several threads.
/// Build O(N); a query costs a few buckets where points are near.
class PointIndex {
 public:
  struct Neighbour {
    int index = -1;           ///< column of the points given, -1 = none within the radius
    double squared_m2 = 0.0;  ///< of the distance
    explicit operator bool() const { return index >= 0; }
  };

  /// @param points 2×N [m], any N; a point that is not finite is never found.
  /// @param cell_m bucket size > 0; larger when spread points would need far too many buckets.
  explicit PointIndex(const Points2& points, double cell_m = 0.25);

  /// The exact nearest point no farther than `radius_m`; of equally near ones the lowest index.
  Neighbour nearest(const Eigen::Vector2d& query, double radius_m) const;

  const Points2& points() const { return points_; }

 private:
  struct Box {
    int x0, y0, x1, y1;
  };
  void search_cell(int x, int y, const Eigen::Vector2d& query, Neighbour& best) const;
  void search_ring(const Box& ring, const Eigen::Vector2d& query, Neighbour& best) const;

  Points2 points_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  double cell_m_;
  int width_ = 0, height_ = 0;
  std::vector<int> cell_begin_;  // width·height + 1: buckets as ranges of order_
  std::vector<int> order_;
};

}  // namespace marco::slam
