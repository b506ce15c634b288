#include "slam/calibration/beam_fit.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

// What a laser's messages say wrongly, and where it sits.
struct Laser {
  double first_deg = -120.0;
  double step_deg = 1.0;
  int beams = 241;
  double true_scale = 1.0;   // of its bearings
  double true_offset = 0.0;  // of its ranges [m]
  Pose2 robot_from_sensor = {};
};

// Rounds through a room, as a map has them: right but for some millimetres.
std::vector<Keyframe> drive(const Laser& laser, unsigned seed) {
  const testing::FlatWorld room = testing::small_room();
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Keyframe> keys;
  for (int i = 0; i < 80; ++i) {
    const double way = 0.25 * i;
    const Pose2 robot{-1.0 + 1.5 * std::sin(0.5 * way), -0.6 + 0.8 * std::sin(0.8 * way),
                      0.9 * way};
    const Pose2 sensor = robot * laser.robot_from_sensor;
    Points2 points(2, laser.beams);
    for (int beam = 0; beam < laser.beams; ++beam) {
      const double said_rad = deg_to_rad(laser.first_deg + laser.step_deg * beam);
      const double range_m =
          room.range_m(sensor.translation_m(), sensor.theta_rad + laser.true_scale * said_rad) -
          laser.true_offset + 0.01 * normal(random);
      points.col(beam) = range_m * Eigen::Vector2d(std::cos(said_rad), std::sin(said_rad));
    }
    Keyframe& key = keys.emplace_back();
    key.sensor_in_robot = laser.robot_from_sensor.translation_m();
    key.sensor_heading_rad = laser.robot_from_sensor.theta_rad;
    key.points_in_robot =
        orient(laser.robot_from_sensor * points, key.sensor_in_robot, NormalOptions{});
    key.world_from_robot = robot * Pose2{0.01 * normal(random), 0.01 * normal(random),
                                         deg_to_rad(0.3) * normal(random)};
  }
  return keys;
}

std::optional<BeamFit> found_of(const Laser& laser, unsigned seed = 1) {
  return fit_beams(drive(laser, seed), deg_to_rad(laser.first_deg));
}

TEST(BeamFit, RightBeamsAreLeftAsTheyAre) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto found = found_of({}, seed);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->bearing_scale.value, 1.0, 0.003) << seed;
    EXPECT_NEAR(found->range_offset_m.value, 0.0, 0.01) << seed;
    EXPECT_FALSE(found->bearing_scale.differs_from(1.0)) << seed;
    EXPECT_FALSE(found->range_offset_m.differs_from(0.0)) << seed;
  }
}

TEST(BeamFit, BearingsTooWideOrTooNarrowAreFoundWhereverTheLaserSits) {
  for (const double scale : {0.95, 0.98, 1.015, 1.05}) {
    for (const Pose2& place : {Pose2{}, Pose2{0.2, -0.1, 2.5}}) {
      Laser laser;
      laser.true_scale = scale;
      laser.robot_from_sensor = place;
      const auto found = found_of(laser);
      ASSERT_TRUE(found);
      EXPECT_NEAR(found->bearing_scale.value, scale, 0.004) << scale;
      EXPECT_TRUE(found->bearing_scale.differs_from(1.0)) << scale;
      EXPECT_FALSE(found->range_offset_m.differs_from(0.0)) << scale;
    }
  }
}

// The same rays, counted from ahead or from behind, are stretched about another bearing.
TEST(BeamFit, ALaserThatSeesAllAroundIsCountedFromItsFirstBeam) {
  for (const double first_deg : {0.0, -180.0}) {
    Laser laser{first_deg, 1.0, 350};
    laser.true_scale = 1.02;
    const auto found = found_of(laser);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->bearing_scale.value, 1.02, 0.004) << first_deg;
  }
}

TEST(BeamFit, ALargeOffsetOfTheRangesIsFoundASmallOneIsNotSaid) {
  for (const double offset_m : {-0.06, 0.06}) {
    Laser laser;
    laser.true_offset = offset_m;
    const auto found = found_of(laser);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->range_offset_m.value, offset_m, 0.01) << offset_m;
    EXPECT_TRUE(found->range_offset_m.differs_from(0.0)) << offset_m;
    EXPECT_FALSE(found->bearing_scale.differs_from(1.0)) << offset_m;
  }
  Laser laser;
  laser.true_offset = 0.01;
  EXPECT_FALSE(found_of(laser)->range_offset_m.differs_from(0.0));
}

// People, open doors: what some pairs see has moved between them.
TEST(BeamFit, PairsThatDisagreeMakeItLessSure) {
  std::vector<Keyframe> keys = drive({}, 1);
  keys.resize(16);
  const auto sure = fit_beams(keys, deg_to_rad(-120.0));
  for (std::size_t i = 0; i < keys.size(); i += 2) {
    Points2& points = keys[i].points_in_robot.points;
    for (Eigen::Index k = 0; k < 80; ++k)
      points.col(k) *= 1.0 + 0.04 * std::sin(0.7 * static_cast<double>(i));
  }
  const auto doubtful = fit_beams(keys, deg_to_rad(-120.0));
  ASSERT_TRUE(sure && doubtful);
  EXPECT_GT(doubtful->bearing_scale.sigma, 1.02 * sure->bearing_scale.sigma);
  EXPECT_FALSE(doubtful->bearing_scale.differs_from(1.0));
}

TEST(BeamFit, NothingIsSaidOfTooFewPlaces) {
  std::vector<Keyframe> keys = drive({}, 1);
  keys.resize(5);
  EXPECT_FALSE(fit_beams(keys, deg_to_rad(-120.0)));
  EXPECT_FALSE(fit_beams({}, 0.0));
  Keyframe blind;
  blind.points_in_robot = {Points2(2, 0), Points2(2, 0), 0.0};
  EXPECT_FALSE(fit_beams(std::vector<Keyframe>(60, blind), 0.0));
}

TEST(CellsOfWalls, ABlurredMapNeedsMore) {
  Laser laser;
  const std::size_t right = cells_of_walls(drive(laser, 1));
  laser.true_scale = 1.03;
  EXPECT_GT(static_cast<double>(cells_of_walls(drive(laser, 1))), 1.1 * static_cast<double>(right));
  EXPECT_EQ(cells_of_walls({}), 0U);
}

}  // namespace
}  // namespace marco::slam
