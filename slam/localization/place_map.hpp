#pragma once

#include <vector>

#include "common/grid_map.hpp"
#include "common/options.hpp"
#include "slam/grid/occupancy_grid.hpp"
#include "slam/localization/place_search.hpp"
#include "slam/loop_closer.hpp"
#include "slam/matching/correlative_matcher.hpp"

namespace marco::slam {

struct PlaceMapOptions {
  double cell_m = 0.10;  ///< of the likelihood of walls that is searched; coarser in a huge map
  double blur_m = 0.10;  ///< standard deviation of a wall there
  int levels = 6;        ///< of the search, each twice as coarse
  OccupancyGridOptions grid;

  template <class Visitor>
  void visit(Visitor& v) {
    v("cell_m", cell_m, Limits{0.02, 1.0});
    v("blur_m", blur_m, Limits{0.02, 1.0});
    v("levels", levels, Limits{1, 10});
    v("grid", grid);
  }
};

/// A saved map as a finder of places wants it: where walls are likely, and where it is known to be
/// free. Const: safe from several threads.
class PlaceMap {
 public:
  /// @throws std::invalid_argument when there is no point, or the map is larger than 400 km^2.
  PlaceMap(const std::vector<KeyScan>& keys, const PlaceMapOptions& options);

  const LikelihoodPyramid& walls() const { return walls_; }
  const BlockTable& blocks() const { return blocks_; }
  /// Likelihood of a wall at a point, 0..1, and how it grows along x and y [1/m].
  struct Likelihood {
    double value = 0.0;
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  };
  Likelihood likelihood(const Eigen::Vector2d& point_in_map) const;
  /// Known to be free.
  bool is_free(const Eigen::Vector2d& point_in_map) const;
  /// Known to hold a wall.
  bool is_wall(const Eigen::Vector2d& point_in_map) const;

 private:
  uint8_t occupancy(const Eigen::Vector2d& point_in_map) const;

  LikelihoodPyramid walls_;
  BlockTable blocks_;
  GridMap grid_;
};

}  // namespace marco::slam
