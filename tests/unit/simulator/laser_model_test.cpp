#include "simulator/laser_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace marco::sim {
namespace {

// A wall across the way at x = 2 of the given material, a plain one behind it at x = 4, and one
// behind the laser at x = -3.
World walls(Material front) {
  World world;
  const auto wall = [&world](double x, Material material) {
    world.add_quad({Eigen::Vector3d(x, -60, -9), {x, 60, -9}, {x, 60, 9}, {x, -60, 9}}, material);
  };
  wall(2, front);
  wall(4, Material::plain);
  wall(-3, Material::plain);
  return world;
}

LaserOptions exact() {
  LaserOptions options;
  options.range_sigma_m = 0.0;
  options.missing_part = 0.0;
  options.footprint_deg = 0.0;
  options.interlaced_turns = 1;
  options.scan_duration_s = 0.0;
  return options;
}

std::vector<float> scan_of(const World& world, const LaserOptions& options, double yaw_deg = 0.0) {
  const RayCaster rays(world);
  const LaserModel laser(rays, options);
  std::mt19937_64 random(5);
  const Pose3 pose = make_pose3({0, 0, 0}, 0, 0, deg_to_rad(yaw_deg));
  return laser.scan([&](double) { return LaserMoment{pose}; }, random);
}

// The beam at a bearing [deg] of the default fan.
float at_deg(const std::vector<float>& ranges_m, double bearing_deg) {
  return ranges_m[static_cast<std::size_t>(std::lround((bearing_deg + 90.0) / 0.5))];
}

TEST(LaserModel, PlainWallsAreMeasuredToTheMillimetre) {
  const auto ranges_m = scan_of(walls(Material::plain), exact());
  EXPECT_FLOAT_EQ(at_deg(ranges_m, 0), 2.0F);
  EXPECT_NEAR(at_deg(ranges_m, 60), 4.0, 5.1e-4);  // quantum 1 mm
}

TEST(LaserModel, BlackReturnsNothingAtASlant) {
  const auto ranges_m = scan_of(walls(Material::black), exact());
  EXPECT_FLOAT_EQ(at_deg(ranges_m, 0), 2.0F);
  EXPECT_FLOAT_EQ(at_deg(ranges_m, 54),
                  static_cast<float>(std::round(2000 / std::cos(deg_to_rad(54))) / 1000));
  EXPECT_FLOAT_EQ(at_deg(ranges_m, 58), 32.759F);
}

TEST(LaserModel, GlassIsSeenSeenThroughOrAMirrorByTheAngle) {
  const auto ranges_m = scan_of(walls(Material::glass), exact());
  EXPECT_FLOAT_EQ(at_deg(ranges_m, 0), 2.0F);                               // straight on
  EXPECT_NEAR(at_deg(ranges_m, 30), 4.0 / std::cos(deg_to_rad(30)), 2e-3);  // through it
  // Reflected at 75 deg: 2 m to the pane and 5 m back to the wall behind, along the slant.
  EXPECT_NEAR(at_deg(ranges_m, 75), 7.0 / std::cos(deg_to_rad(75)), 5e-2);
}

TEST(LaserModel, NoiseHasTheSigmaItSays) {
  LaserOptions options = exact();
  options.range_sigma_m = 0.010;
  options.quantum_m = 0.0;
  const RayCaster rays(walls(Material::plain));
  const LaserModel laser(rays, options);
  std::mt19937_64 random(11);
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (int i = 0; i < 40; ++i) {
    const auto ranges_m = laser.scan([](double) { return LaserMoment{}; }, random);
    for (double deg = -60; deg <= 60; deg += 0.5) {
      const double error =
          static_cast<double>(at_deg(ranges_m, deg)) - 2.0 / std::cos(deg_to_rad(deg));
      sum += error;
      squares += error * error;
      ++count;
    }
  }
  // 9640 samples: the mean to 0.1 mm, sigma to 0.7 %; four times that.
  EXPECT_NEAR(sum / count, 0.0, 0.0004);
  EXPECT_NEAR(std::sqrt(squares / count), 0.010, 0.0003);
}

TEST(LaserModel, AnEdgeMixesWhatLiesBeforeAndBehindIt) {
  World world;
  world.add_quad({Eigen::Vector3d(2, 0, -9), {2, 9, -9}, {2, 9, 9}, {2, 0, 9}}, Material::plain);
  world.add_quad({Eigen::Vector3d(2.6, -9, -9), {2.6, 9, -9}, {2.6, 9, 9}, {2.6, -9, 9}},
                 Material::plain);
  LaserOptions options = exact();
  options.footprint_deg = 0.5;
  const auto ranges_m = scan_of(world, options);
  const float edge = at_deg(ranges_m, 0);
  EXPECT_GT(edge, 2.0F);
  EXPECT_LT(edge, 2.61F);
  EXPECT_NEAR(at_deg(ranges_m, 2), 2.0, 0.01);
  EXPECT_NEAR(at_deg(ranges_m, -2), 2.6, 0.01);
}

TEST(LaserModel, AScanIsMadeWhileTheRobotMoves) {
  LaserOptions options = exact();
  options.scan_duration_s = 1.0;
  const RayCaster rays(walls(Material::plain));
  const LaserModel laser(rays, options);
  std::mt19937_64 random(1);
  // Half a metre nearer when the middle beam is measured, at half of the second.
  const auto ranges_m = laser.scan(
      [](double t) {
        return LaserMoment{make_pose3({t, 0, 0})};
      },
      random);
  EXPECT_NEAR(at_deg(ranges_m, 0), 1.5, 1e-3);
}

}  // namespace
}  // namespace marco::sim
