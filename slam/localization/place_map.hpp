#pragma once

#include <vector>

#include "common/grid_map.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/grid/occupancy_grid.hpp"
#include "slam/localization/place_search.hpp"
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

/// Where beams ended, and where each came from.
struct Beams {
  Points2 ends;
  Points2 sensors;
  std::vector<double> clear_m;  ///< how far from its sensor each keeps off any wall
};

/// How far a beam keeps off all walls [m]; 0 where that cannot be known.
/// @param beam  from the sensor to its end; @param normal  of the wall there
double clear_length_m(const Eigen::Vector2d& beam, const Eigen::Vector2d& normal);

/// What a map says to beams, in parts of their number. The rest lies where the map knows nothing.
struct Agreement {
  double explained = 0.0;     ///< end on walls
  double in_free = 0.0;       ///< end where the map knows free space
  double through_wall = 0.0;  ///< go through a wall: it is another place, or a door was opened
  double contradicted() const { return in_free + through_wall; }
  double evidence() const { return explained - contradicted(); }
};

/// A saved map as a finder of places wants it: where walls are likely, and where it is known to be
/// free. Const: safe from several threads.
class PlaceMap {
 public:
  /// @throws std::invalid_argument when there is no point, or the map is larger than 400 km^2.
  PlaceMap(const std::vector<Keyframe>& keys, const PlaceMapOptions& options);

  const LikelihoodPyramid& walls() const { return walls_; }
  const BlockTable& blocks() const { return blocks_; }
  /// Likelihood of a wall at a point, 0..1, and how it grows along x and y [1/m].
  struct Likelihood {
    double value = 0.0;
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  };
  Likelihood likelihood(const Eigen::Vector2d& point_in_map) const;
  /// @param beams  at least one
  Agreement agreement(const Beams& beams, const Pose2& map_from_beams) const;
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
