#pragma once

#include <cstdio>
#include <random>
#include <string>

#include "tests/support/flat_world.hpp"

namespace marco::testing {

inline constexpr int kRingScans = 1200;

/// A CARMEN log: three times round a ring of rooms, a scan each 0.1 m or 9 degrees, ten a second
/// from 1000 s on; a round takes 40 s. @param way_scale, turn_scale  of the odometry
/// @param heading_unit  its heading is that many times too large. @param bearing_scale  true
/// bearing over the one that the format means
/// @param laser  where it sits on the robot: the format means the robot's place and heading
inline std::string ring_log(double way_scale,
                            double turn_scale,
                            double heading_unit = 1.0,
                            double bearing_scale = 1.0,
                            const Pose2& laser = {}) {
  FlatWorld world;
  world.add_box(-7, -5, 7, 5);
  world.add_box(-4, -2, 4, 2);
  world.add_box(5.8, -0.5, 6.2, 0.1);
  world.add_box(-6.5, 3.0, -6.0, 3.6);
  world.add_box(1.0, -4.7, 2.1, -4.3);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::string log;
  Pose2 robot{-5.5, -3.5, 0.0}, odom;
  const int sides[] = {110, 70, 110, 70};
  for (int i = 0, side = 0, on_side = 0; i < kRingScans; ++i) {
    log += "FLASER 180";
    const Pose2 eye = robot * laser;
    for (int beam = 0; beam < 180; ++beam) {
      const double bearing_rad = eye.theta_rad + bearing_scale * deg_to_rad(beam - 90.0);
      char text[20];
      std::snprintf(text, sizeof text, " %.3f",
                    world.range_m(eye.translation_m(), bearing_rad) + noise(random));
      log += text;
    }
    char text[200];
    std::snprintf(text, sizeof text, " %.4f %.4f %.5f %.4f %.4f %.5f %.6f host %.6f\n", odom.x_m,
                  odom.y_m, heading_unit * odom.theta_rad, odom.x_m, odom.y_m,
                  heading_unit * odom.theta_rad, 1000.0 + 0.1 * i, 1000.0 + 0.1 * i);
    log += text;
    const bool turns = on_side >= sides[side];
    const Pose2 step = turns ? Pose2{0, 0, deg_to_rad(9)} : Pose2{0.1, 0, 0};
    robot = robot * step;
    odom = odom * Pose2{way_scale * step.x_m, 0.0, turn_scale * step.theta_rad};
    if (++on_side == sides[side] + 10) {
      on_side = 0;
      side = (side + 1) % 4;
    }
  }
  return log;
}

}  // namespace marco::testing
