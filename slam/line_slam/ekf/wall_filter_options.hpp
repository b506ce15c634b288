#pragma once

#include <string>

#include "lcm_tools/base/options.hpp"
#include "slam/line_slam/ekf/motion.hpp"
#include "slam/line_slam/ekf/similar.hpp"
#include "slam/line_slam/ekf/wall_evidence.hpp"

namespace marco::slam {

struct WallFilterOptions {
  MotionNoiseOptions motion;
  SimilarOptions similar;             ///< limits of `similar`; widened by the pose's uncertainty
  std::string association = "joint";  ///< "joint" (innovation gates, JCBB) or "similar"
  double gate_probability = 0.99;     ///< of accepting a true pairing
  double end_distance_m = 0.10;       ///< d_l: closer ends are the same end
  double max_end_distance_m = 0.5;    ///< ... whatever the pose's uncertainty
  double across_floor_m = 0.01;       ///< lower bound of a wall's error: no wall is quite straight
  double direction_floor_rad = 0.003;
  double join_sigma_m = 0.01;   ///< how well the parts of one wall lie on one line
  double start_sigma_m = 1e-3;  ///< of the first pose (5.40); not 0
  double start_sigma_rad = 1e-3;
  int new_wall_points = 8;          ///< walls with fewer points are not added to the map
  double new_wall_length_m = 0.80;  ///< nor shorter ones
  double judged_within_m = 24.0;    ///< rays judge walls no farther away
  WallEvidenceOptions evidence;

  template <class Visitor>
  void visit(Visitor& v) {
    v("motion", motion);
    v.advanced("association", association,
               "'joint': joint compatibility of all walls of a scan; 'similar': each wall for "
               "itself by angle and distance, as in thesis A.");
    v.advanced("gate_probability", gate_probability, Limits{0.5, 0.999999},
               "Probability that the gate accepts a true pairing of walls.");
    v.advanced("end_distance_m", end_distance_m, kPositive,
               "Ends of walls nearer than this are the same end (thesis A: d_l).");
    v.advanced("across_floor_m", across_floor_m, kNotNegative,
               "Lower bound of the standard deviation of a wall's place. More for rough walls.");
    v.advanced("new_wall_points", new_wall_points, Limits{3, 1000},
               "Walls with fewer points are not added to the map. Less for lasers with few beams.");
    v("new_wall_length_m", new_wall_length_m, kNotNegative,
      "Shorter walls are not added to the map. Less for small arenas.");
  }
};

}  // namespace marco::slam
