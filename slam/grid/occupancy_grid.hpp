#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "common/grid_map.hpp"
#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

struct OccupancyGridOptions {
  double resolution_m = 0.05;
  /// One scan's evidence for a cell that it hits or passes through, as probabilities.
  double hit_probability = 0.70;
  double miss_probability = 0.40;
  /// Evidence is bounded, so that the map can change (a door opens).
  double max_probability = 0.98;
  double min_probability = 0.02;
  double max_free_range_m = 30.0;  ///< beyond it a beam no longer clears cells

  template <class Visitor>
  void visit(Visitor& v) {
    v("resolution_m", resolution_m, Limits{0.005, 1.0}, "Cell size of the map.");
    v.advanced("hit_probability", hit_probability, Limits{0.5, 0.999},
               "Probability that a cell is occupied when one beam ends in it.");
    v.advanced("miss_probability", miss_probability, Limits{0.001, 0.5},
               "Probability that a cell is occupied when one beam passes through it. Less to erase "
               "people sooner.");
    v("max_free_range_m", max_free_range_m, kPositive,
      "Beams clear cells up to this range. Less where far ranges are unreliable.");
  }
};

/// Occupancy grid of log-odds (Moravec & Elfes; Thrun, Burgard, Fox, Probabilistic Robotics, table
/// 9.1). What differs: a scan updates a cell at most once, and a cell that it both hits and passes
/// through counts as hit. Grows in tiles, which can be redrawn one by one. Not thread-safe. Limits:
/// kMostCells in the bounding box, and kLongestSide of it; beams that would exceed them are
/// dropped.
class OccupancyGrid {
 public:
  static constexpr int64_t kMostCells = 64'000'000;  ///< 400 x 400 m of 5 cm
  static constexpr int64_t kLongestSide = 100'000;   ///< 5 km of 5 cm

  explicit OccupancyGrid(const OccupancyGridOptions& options = {});
  ~OccupancyGrid();
  OccupancyGrid(OccupancyGrid&&) noexcept;
  OccupancyGrid& operator=(OccupancyGrid&&) noexcept;

  /// @param hits_in_world  2xN [m]; points that are not finite are an error of the caller.
  /// @param sensor_in_world  [m] where the beams came from.
  /// Cost O(sum of beam lengths / resolution).
  void insert(const Points2& hits_in_world, const Eigen::Vector2d& sensor_in_world);

  /// Tiles of 64 x 64 cells, by their keys.
  using Tiles = std::unordered_set<uint64_t>;
  struct TileBox {
    Eigen::Array2i min = {0, 0};
    Eigen::Array2i max = {0, 0};
  };
  /// Contains all cells that insert() of the same scan would touch.
  TileBox box_of(const Points2& hits_in_world, const Eigen::Vector2d& sensor_in_world) const;
  static void add(const TileBox& box, Tiles& tiles);
  static bool touches(const TileBox& box, const Tiles& tiles);
  /// Before insert_in(): this grid will hold tiles of `whole` and shares its limits.
  void be_part_of(const OccupancyGrid& whole) { cells_ = whole.cells_; }
  /// As insert(), but changes these tiles only.
  void insert_in(const Tiles& tiles,
                 const Points2& hits_in_world,
                 const Eigen::Vector2d& sensor_in_world);
  /// Replaces these tiles by those of `other`.
  void replace(const Tiles& tiles, OccupancyGrid other);

  void clear();
  bool empty() const { return tiles_.empty(); }
  /// Size that the map would need for the dropped beams [m]; nothing when none was dropped.
  std::optional<Eigen::Vector2d> too_large_m() const { return too_large_m_; }

  /// 0.5 in unknown space.
  double probability(const Eigen::Vector2d& point_in_world) const;

  /// The known part as a value; an empty map without scans.
  GridMap to_map() const;

 private:
  static constexpr int kTileBits = 6;
  static constexpr int kTileCells = 1 << kTileBits;
  struct Cell {
    float log_odds = 0.0F;
    uint32_t last_scan = 0;  ///< 0 = never seen
  };
  struct Tile {
    std::array<Cell, static_cast<std::size_t>(kTileCells) * kTileCells> cells;
  };

  /// nullptr in tiles that insert_in() must not change.
  Cell* cell_at(int x_cell, int y_cell);
  void draw(const Points2& hits_in_world, const Eigen::Vector2d& sensor_in_world);
  /// Whether the point is within the box, or the box could be made larger.
  bool make_room(const Eigen::Vector2d& at_cells);
  int tile_of(double coordinate_m) const;
  static std::size_t within_tile(int x_cell, int y_cell);
  const Cell* find_cell(int x_cell, int y_cell) const;
  void clear_along(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells);

  OccupancyGridOptions options_;
  float hit_log_odds_;
  float miss_log_odds_;
  float min_log_odds_;
  float max_log_odds_;
  uint32_t scan_ = 0;
  std::optional<TileBox> cells_;  ///< bounding box of all scans, in cells
  std::optional<Eigen::Vector2d> too_large_m_;
  std::unordered_map<uint64_t, std::unique_ptr<Tile>> tiles_;
  std::optional<uint64_t> last_key_;  ///< of `last_tile_`
  Tile* last_tile_ = nullptr;         ///< beams stay in a tile for many cells
  const Tiles* only_ = nullptr;       ///< of insert_in()
};

}  // namespace marco::slam
