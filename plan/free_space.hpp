#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "slam/map/keyframe.hpp"

namespace marco::plan {

/// Where beams went through, as a raster in the plan's frame. A cell is free where at least two
/// keyframes saw through it, three times as many as were stopped in it: who walked by is gone.
class FreeSpace {
 public:
  static constexpr double kCellM = 0.05;  ///< the map's

  FreeSpace(const std::vector<slam::Keyframe>& keys, const Pose2& plan_from_map);

  int width() const { return width_; }
  int height() const { return height_; }
  int cell_of(const Eigen::Vector2d& point) const;  ///< -1 outside
  Eigen::Vector2d centre_of(int cell) const;
  bool is_free(int cell) const { return cell >= 0 && free_[static_cast<std::size_t>(cell)] != 0; }
  bool is_free(const Eigen::Vector2d& point) const { return is_free(cell_of(point)); }
  /// Whether a beam ended within a cell of here.
  bool is_hit(int cell) const;
  /// What a face stands on is not free, though beams went through glass.
  void close(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  /// Takes away what is narrower than 25 cm: single beams' fans.
  void smooth();

 private:
  void look(const slam::Keyframe& key, const Pose2& plan_from_robot, int stamp);

  Eigen::Vector2d low_ = {0, 0};
  int width_ = 0, height_ = 0;
  std::vector<uint8_t> free_;
  std::vector<int> through_, stopped_, last_;
};

}  // namespace marco::plan
