#pragma once

#include <array>
#include <limits>
#include <vector>

#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// A plane m x = 1 fitted to a window of beams, about the scene's mean sensor, and what noise does
/// to it. A beam of unit direction q has the inverse range m q.
struct WindowPlane {
  Eigen::Vector3d m = Eigen::Vector3d::Zero();
  /// Rms of the inverse ranges [1/m]; infinite where too few beams returned.
  double residual = std::numeric_limits<double>::infinity();
  double by_range = 0.0;      ///< mean square of what 1 m of range noise does to an inverse range
  double by_direction = 0.0;  ///< likewise of 1 rad of noise in the beams' directions
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of m, for inverse ranges of variance 1
};

/// Rows and columns from a window's middle to its edge.
struct WindowReach {
  int rows = 1;
  int columns = 1;
};

/// Planes in windows of a scene's beams, each in constant time by a summed-area table. A window
/// spans the same angle along rows and columns, however far apart the beams lie: an interlaced scan
/// has rows closer than columns, and at the axis of the pan-tilt all rows meet in one beam.
class SceneWindows {
 public:
  static constexpr int kLargest = 3;  ///< half-width of the largest window, in mean beam steps

  /// @param scene must outlive this object.
  explicit SceneWindows(const ScenePoints& scene);

  int rows() const { return static_cast<int>(scene_.rows); }
  int columns() const { return static_cast<int>(scene_.columns); }
  std::size_t at(int row, int column) const {
    return scene_.index(static_cast<std::size_t>(row), static_cast<std::size_t>(column));
  }
  /// From the mean sensor; 0 = no return.
  double range_m(std::size_t index) const { return ranges_m_[index]; }
  const Eigen::Vector3d& centre_m() const { return centre_m_; }

  /// @param half  of a window about a beam with a return, in mean beam steps: 1 to kLargest
  WindowReach reach(int row, int column, int half) const;
  WindowPlane fit(int row, int column, const WindowReach& reach) const;

 private:
  // q qT (6), q / r (3), 1 / r^2, 1 / r^4, count.
  static constexpr std::size_t kSums = 12;
  using Sums = std::array<double, kSums>;

  void find_beams();
  void add_up();
  float median_step(std::size_t stride) const;
  int steps_within(std::size_t index, int at, int end, std::size_t stride, float angle_rad) const;
  const Sums& sums_at(int row, int column) const {
    return sums_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns() + 1) +
                 static_cast<std::size_t>(column)];
  }

  const ScenePoints& scene_;
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();
  std::vector<Sums> sums_;
  std::vector<double> ranges_m_;
  std::vector<Eigen::Vector3f> beams_;  ///< unit directions
  float spacing_rad_ = 0.0F;            ///< between neighbours: the mean of rows and columns
};

}  // namespace marco::mapping3d
