#pragma once

#include "lcm_tools/base/options.hpp"

namespace marco::slam {

/// Errors of wheels and sightings, as far as they are white noise. Starting values: NoiseLearner
/// replaces them by those that make the drive likeliest.
struct SightingNoise {
  double range_sigma_m = 0.10;
  double bearing_sigma_rad = 0.03;
  double move_sigma_m = 0.10;    ///< of a metre's way, growing with its square root
  double turn_sigma_rad = 0.10;  ///< the same, of the heading

  template <class Visitor>
  void visit(Visitor& v) {
    v("range_sigma_m", range_sigma_m, kPositive,
      "Standard deviation of a sighting's range: initial value.");
    v("bearing_sigma_rad", bearing_sigma_rad, kPositive,
      "Standard deviation of a sighting's bearing: initial value.");
    v("move_sigma_m", move_sigma_m, kPositive,
      "Standard deviation of the wheels' distance after one metre: initial value.");
    v("turn_sigma_rad", turn_sigma_rad, kPositive,
      "Standard deviation of the wheels' heading after one metre: initial value.");
  }
};

/// Constant errors of the robot's set-up, which the filter estimates along with everything else.
/// A standard deviation of 0 keeps the value.
struct SetUpOptions {
  double sensor_ahead_m = 0.0;  ///< of the point that `speed` is the speed of
  double sensor_left_m = 0.0;
  double sensor_yaw_rad = 0.0;
  double sensor_sigma_m = 0.2;
  double sensor_yaw_sigma_rad = 0.03;
  double speed_scale_sigma = 0.05;
  double turn_scale_sigma = 0.05;
  double turn_bias_sigma_rad_per_s = 0.01;

  template <class Visitor>
  void visit(Visitor& v) {
    v("sensor_ahead_m", sensor_ahead_m,
      "The sensor's position ahead of the point whose speed the wheels measure.");
    v("sensor_left_m", sensor_left_m, "The same, to the left.");
    v("sensor_yaw_rad", sensor_yaw_rad, "Where the sensor's bearing 0 points, counter-clockwise.");
    v("sensor_sigma_m", sensor_sigma_m, kNotNegative,
      "Standard deviation of the sensor's position. 0 = exactly known: not estimated.");
    v("sensor_yaw_sigma_rad", sensor_yaw_sigma_rad, kNotNegative,
      "Standard deviation of the sensor's heading. 0 = exactly known.");
    v("speed_scale_sigma", speed_scale_sigma, kNotNegative,
      "Standard deviation of the wheels' scale, as a fraction. 0 = exactly known.");
    v("turn_scale_sigma", turn_scale_sigma, kNotNegative,
      "Standard deviation of the turn rate's scale, as a fraction. 0 = exactly known.");
    v("turn_bias_sigma_rad_per_s", turn_bias_sigma_rad_per_s, kNotNegative,
      "Standard deviation of the turn rate's zero. 0 = exactly known.");
  }
};

struct LandmarkSlamOptions {
  SightingNoise noise;
  bool learn_noise = true;
  SetUpOptions set_up;
  double gate_probability = 0.995;  ///< of accepting a true pairing
  int confirm_sightings = 3;        ///< of a provisional landmark before it joins the filter

  template <class Visitor>
  void visit(Visitor& v) {
    v("noise", noise);
    v("learn_noise", learn_noise, "Estimate the noise during the drive.");
    v("set_up", set_up);
    v.advanced("gate_probability", gate_probability, Limits{0.5, 0.999999},
               "Probability that the gate accepts a true pairing of sightings with landmarks.");
    v.advanced("confirm_sightings", confirm_sightings, Limits{1, 1000},
               "Sightings of a new landmark before it counts. More where there is much clutter.");
  }
};

}  // namespace marco::slam
