#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "slam/matching/oriented_points.hpp"

namespace marco::slam {

/// A small piece of wall: what thesis B calls the line of calculated points, shared by all points
/// of several scans that fall into one cell and face the same way.
struct Surfel {
  Eigen::Vector2f mean_m = Eigen::Vector2f::Zero();  ///< relative to the map's centre
  Eigen::Vector2f normal = Eigen::Vector2f::Zero();  ///< unit length, towards free space
  float weight = 0.0F;                               ///< points in it
  int32_t next = -1;                                 ///< another one of the same cell
};

/// A local map of surfels at one resolution: O(1) look-up, made anew when its scans move.
/// Positions are kept relative to `centre_m`, so that floats stay exact far from the origin.
/// Const members are safe from several threads.
class SurfelMap {
 public:
  /// @param centre_m  middle of the square covered, map frame
  /// @param half_width_m  points outside the square are left out
  SurfelMap(const Eigen::Vector2d& centre_m, double half_width_m, double cell_m);

  /// @param map_from_points  places the points; those without a normal are left out.
  void add(const OrientedPoints& points, const Pose2& map_from_points);

  /// The surfel nearest across its line to a point, among those of the four cells around it.
  /// @param point_m, normal  relative to the centre; normal (0, 0) fits any surfel.
  /// @returns nullptr when none faces the same way.
  const Surfel* find(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal) const;

  const Eigen::Vector2d& centre_m() const { return centre_m_; }
  double cell_m() const { return cell_m_; }
  std::size_t size() const { return surfels_.size(); }

 private:
  void add_point(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal);

  Eigen::Vector2d centre_m_;
  double cell_m_;
  float half_width_m_;
  float inverse_cell_;
  int width_;
  std::vector<int32_t> first_;  ///< of each cell, -1 = none
  std::vector<Surfel> surfels_;
};

}  // namespace marco::slam
