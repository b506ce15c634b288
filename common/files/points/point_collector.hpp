#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/point_cloud.hpp"

namespace marco::files {

/// Takes the points of a file one by one, in double, and keeps them as float: those of a survey,
/// beyond 10 km, from the first finite point, rounded to whole metres.
class PointCollector {
 public:
  struct Parts {
    bool intensities = false, colors = false;
  };

  /// @param origin_m  where it is known that the points lie far
  explicit PointCollector(std::optional<Eigen::Vector3d> origin_m = std::nullopt);

  /// Reserves memory for this many points and what `more` says of each.
  void reserve(std::size_t points, Parts more);
  void add(const Eigen::Vector3d& point_m);

  /// Where a later point than the first lies far: read them again, from this origin.
  std::optional<Eigen::Vector3d> better_origin_m() const;

  PointCloud cloud;  ///< the caller adds intensities, colours, rows and pose

 private:
  std::optional<Eigen::Vector3d> first_m_;
  bool has_origin_ = false, is_far_ = false;
};

/// The cloud that `read(PointCollector&)` collects. It is called twice where only the first points
/// of a file are near.
template <class Read>
PointCloud collect_points(const Read& read) {
  PointCollector points;
  read(points);
  if (const auto origin_m = points.better_origin_m()) {
    points = PointCollector(origin_m);
    read(points);
  }
  return std::move(points.cloud);
}

}  // namespace marco::files
