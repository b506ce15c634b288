#pragma once

#include "lcm_tools/base/options.hpp"

namespace marco::slam {

/// Defaults of thesis A, chapter 4.
struct LineExtractorOptions {
  double range_sigma_m = 0.01;     ///< where the laser's is not known
  double split_distance_m = 0.05;  ///< d_s: largest distance of a point from its line
  double max_gap_m = 0.35;         ///< a wider gap between neighbouring points cuts a wall ...
  double max_grazing_gap_m = 1.2;  ///< ... or this one, where the beams graze the wall
  int min_points = 5;
  double min_length_m = 0.40;
  double max_range_m = 20.0;       ///< farther points are not used (thesis: 8, its laser's limit)
  int max_outliers_in_a_row = 4;   ///< more consecutive outliers end a wall
  double touch_m = 0.12;           ///< closer hits belong to one surface
  double trim_sigmas = 3.0;        ///< points farther from the fitted line are left out of the fit
  double surface_sigma_m = 0.002;  ///< roughness of real walls: lower bound of a point's error
  double least_step_m = 0.025;     ///< smallest offset across at which one wall becomes two
  double max_roughness_sigmas = 2.0;  ///< walls whose points scatter more are clutter ...
  double rough_length_m = 2.0;        ///< ... unless they are at least this long

  template <class Visitor>
  void visit(Visitor& v) {
    v("range_sigma_m", range_sigma_m, kPositive,
      "Standard deviation of a range where SENSOR_INFO gives none. Set it to the laser's.");
    v.advanced("split_distance_m", split_distance_m, Limits{1e-4, 1.0},
               "Largest distance of a point from its line (thesis A: d_s). More for noisy ranges.");
    v("max_gap_m", max_gap_m, Limits{1e-3, 10.0},
      "A wider gap between neighbouring points ends a wall. More for few beams or far walls.");
    v.advanced("max_grazing_gap_m", max_grazing_gap_m, Limits{1e-3, 10.0},
               "A wider gap ends a wall at grazing incidence.");
    v("min_points", min_points, Limits{3, 1000},
      "Minimum number of points on a wall. Less for lasers with few beams.");
    v("min_length_m", min_length_m, kPositive,
      "Shortest wall that is extracted. Less for small arenas.");
    v("max_range_m", max_range_m, kPositive,
      "Farther points are not used. Less where far ranges are unreliable.");
    v.advanced("surface_sigma_m", surface_sigma_m, kPositive,
               "Roughness of real walls: lower bound of the standard deviation of a point.");
    v.advanced("max_roughness_sigmas", max_roughness_sigmas, Limits{1.0, 1000.0},
               "Points that scatter more about their line are clutter, not a wall.");
  }
};

}  // namespace marco::slam
