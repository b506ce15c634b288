#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "slam/matching/oriented_points.hpp"

namespace marco::slam {

/// A surfel: a small piece of wall. All points of several scans in one cell with similar normals
/// share it; thesis B calls it the line of calculated points.
struct Surfel {
  Eigen::Vector2f mean_m = Eigen::Vector2f::Zero();  ///< relative to the map's centre
  Eigen::Vector2f normal = Eigen::Vector2f::Zero();  ///< unit length, towards free space
};

/// The line through a surfel: distance across the wall = nx x + ny y - offset.
struct WallLine {
  float nx = 0.0F, ny = 0.0F;  ///< both 0: no surfel was found
  float offset_m = 0.0F;
};

/// A local map of surfels at one resolution, with O(1) look-up; rebuilt when its scans move.
/// Positions are relative to `centre_m`, so that floats stay exact far from the origin.
///
/// A cell is one cache line with up to four surfels, laid out for the vector unit; a fifth normal
/// in a cell is dropped. Blocks of 8 x 8 cells are allocated on demand; each repeats the first row
/// and column of the next blocks, so that the four cells around a point are always in one block.
/// Memory: O(length of walls). Const members are safe from several threads.
class SurfelMap {
 public:
  /// @param centre_m  centre of the square that the map covers, map frame
  /// @param half_width_m  points outside the square are dropped
  SurfelMap(const Eigen::Vector2d& centre_m, double half_width_m, double cell_m);

  /// Clears the map and moves its centre; memory is kept.
  void restart(const Eigen::Vector2d& centre_m);

  /// Adds a scan. @param map_from_points  pose of the points' frame. Points without a normal are
  /// dropped.
  /// @returns how much of the map the scans before have drawn, where this one sees it: the mean,
  /// over its points, of the squared part that earlier points have in the surfel. 0 of new ground.
  double add(const OrientedPoints& points, const Pose2& map_from_points);

  /// The line through the surfel that find() returns.
  WallLine line_near(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal) const;

  /// The nearest surfel within a cell's width, among those of the four cells around the point.
  /// @param point_m, normal  relative to the centre; normal (0, 0) fits any surfel.
  /// @returns nothing when none has a similar normal.
  std::optional<Surfel> find(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal) const;

  const Eigen::Vector2d& centre_m() const { return centre_m_; }
  double cell_m() const { return cell_m_; }
  std::size_t size() const { return count_; }

 private:
  static constexpr int kBlockBits = 3;
  static constexpr int kBlockCells = 1 << kBlockBits;
  static constexpr int kBlockStride = kBlockCells + 1;
  static constexpr int kSlots = 4;

  struct alignas(64) Cell {
    std::array<float, kSlots> mean_x_m, mean_y_m, normal_x, normal_y;
  };
  using Block =
      std::array<int32_t, std::size_t{kBlockStride} * kBlockStride>;  // cells, 0 = the empty one
  struct Place {
    const Cell* cell;
    int slot;  // -1 = none
  };

  Place nearest(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal) const;
  /// What a surfel is made of.
  struct Parts {
    float points = 0.0F;
    float before = 0.0F;  // the newest scan
    int32_t newest_scan = 0;
  };

  /// @returns the parts of the surfel that the point was added to; null where the cell is full
  const Parts* add_point(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal);
  int32_t cell_at(int x, int y);
  Block& block_at(int x, int y);

  Eigen::Vector2d centre_m_;
  double cell_m_;
  float half_width_m_;
  float inverse_cell_;
  int blocks_wide_;
  std::size_t count_ = 0;
  std::vector<int32_t> table_;  // block of each place, 0 = the empty one
  std::vector<Block> blocks_;
  std::vector<Cell> cells_;
  std::vector<std::array<Parts, kSlots>> parts_;  // of each surfel of each cell
  int32_t scans_ = 0;
};

}  // namespace marco::slam
