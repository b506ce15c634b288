#include "slam/line_slam/lines/line_extractor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/support/lines_world.hpp"

namespace marco::slam {
namespace {

using testing::LinesLaser;
using testing::LinesScan;
using testing::LinesWorld;

double angle_between(double a_rad, double b_rad) {
  return std::abs(normalize_angle(a_rad - b_rad));
}

struct Score {
  int visible = 0, found = 0, invented = 0, compared = 0;
  double chi2_direction = 0.0, chi2_across = 0.0, angle2_long = 0.0;
  int long_walls = 0;
};

// Truth: an edge is visible with at least 8 beams in a row of beams on it within 8 m; it is found
// when an observed wall lies on it.
void score(const LinesWorld& world,
           const LinesScan& taken,
           const Pose2& pose,
           const std::vector<ObservedWall>& observed,
           Score& score) {
  std::map<int, int> beams_on;
  for (std::size_t i = 0; i < taken.edges.size(); ++i) {
    const Beam& beam = taken.scan.beams[i];
    if (taken.edges[i] >= 0 && beam.returned && beam.range_m < 7.95) ++beams_on[taken.edges[i]];
  }
  std::map<int, int> found;
  for (const ObservedWall& wall : observed) {
    int on = -1;
    for (std::size_t e = 0; e < world.edges.size(); ++e) {
      const Eigen::Vector2d way = (world.edges[e].end_m - world.edges[e].start_m).normalized();
      const Eigen::Vector2d center = pose * wall.center_m - world.edges[e].start_m;
      const double direction = normalize_angle(pose.theta_rad + wall.direction_rad);
      const double across = way.x() * center.y() - way.y() * center.x();
      const double along = way.dot(center);
      if (angle_between(direction, std::atan2(way.y(), way.x())) > 0.15 ||
          std::abs(across) > 0.05 || along < 0.0 ||
          along > (world.edges[e].end_m - world.edges[e].start_m).norm()) {
        continue;
      }
      on = static_cast<int>(e);
      const double error = normalize_angle(direction - std::atan2(way.y(), way.x()));
      score.chi2_direction += std::pow(error / wall.direction_sigma_rad, 2);
      score.chi2_across += std::pow(across / wall.across_sigma_m, 2);
      ++score.compared;
      if (wall.length_m() >= 2.0) {
        score.angle2_long += error * error;
        ++score.long_walls;
      }
    }
    if (on < 0) ++score.invented;
    ++found[on];
  }
  for (const auto& [edge, beams] : beams_on) {
    if (beams < 8) continue;
    // Shorter than a wall may be is none.
    Eigen::Vector2d first = Eigen::Vector2d::Zero(), last = Eigen::Vector2d::Zero();
    bool any = false;
    for (std::size_t i = 0; i < taken.edges.size(); ++i) {
      if (taken.edges[i] != edge || taken.scan.beams[i].range_m > 7.95) continue;
      if (!any) first = taken.scan.beams[i].hit_m;
      last = taken.scan.beams[i].hit_m;
      any = true;
    }
    if ((last - first).norm() < 0.45) continue;
    ++score.visible;
    if (found.contains(edge)) ++score.found;
  }
}

Score run(double outlier_part, int scans) {
  const LinesWorld world = testing::make_loop_world();
  LinesLaser laser;
  laser.outlier_part = outlier_part;
  LineExtractorOptions options;
  options.max_range_m = 8.0;
  LineExtractor extractor{options};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(0.5, 13.5), y(0.5, 9.5), heading(-3.1, 3.1);
  Score total;
  for (int i = 0; i < scans;) {
    const Pose2 pose{x(random), y(random), heading(random)};
    bool free = true;
    for (const auto& edge : world.edges) {
      const Eigen::Vector2d way = edge.end_m - edge.start_m;
      const double part =
          std::clamp((pose.translation_m() - edge.start_m).dot(way) / way.squaredNorm(), 0.0, 1.0);
      free = free && (pose.translation_m() - edge.start_m - part * way).norm() > 0.3;
    }
    const bool inside = (pose.x_m > 3 && pose.x_m < 6 && pose.y_m > 3 && pose.y_m < 7) ||
                        (pose.x_m > 8 && pose.x_m < 11 && pose.y_m > 3 && pose.y_m < 7);
    if (!free || inside) continue;
    const LinesScan taken = testing::take_scan(world, laser, pose, random);
    score(world, taken, pose, extractor.extract(taken.scan), total);
    ++i;
  }
  return total;
}

TEST(LineExtractor, FindsTheVisibleWallsAndInventsNone) {
  const Score total = run(0.0, 400);
  std::printf(
      "found %d of %d, invented %d; direction rms/sigma %.3f, across %.3f, >= 2 m: %.3f deg\n",
      total.found, total.visible, total.invented, std::sqrt(total.chi2_direction / total.compared),
      std::sqrt(total.chi2_across / total.compared),
      rad_to_deg(std::sqrt(total.angle2_long / total.long_walls)));
  EXPECT_GE(total.found, 0.99 * total.visible);
  EXPECT_EQ(total.invented, 0);
  EXPECT_NEAR(std::sqrt(total.chi2_direction / total.compared), 1.0, 0.1);
  EXPECT_LE(rad_to_deg(std::sqrt(total.angle2_long / total.long_walls)), 0.3);
}

TEST(LineExtractor, KeepsWallsWithOutliersOnThem) {
  const Score total = run(0.1, 400);
  std::printf("10 %% outliers: found %d of %d, invented %d, direction rms/sigma %.3f\n",
              total.found, total.visible, total.invented,
              std::sqrt(total.chi2_direction / total.compared));
  EXPECT_GE(total.found, 0.97 * total.visible);
  EXPECT_EQ(total.invented, 0);
}

// The scan of what lies ahead at (0, 0), with 1 cm of noise on the ranges.
std::vector<ObservedWall> walls_of(const LinesWorld& world) {
  std::mt19937 random(8);
  LineExtractor extractor{LineExtractorOptions{}};
  return extractor.extract(testing::take_scan(world, LinesLaser{}, Pose2{}, random).scan);
}

// 5 cm is five sigma of one point and less than split_distance + noise, but not for 20 points.
TEST(LineExtractor, PartsAFewCentimetresApartAcrossAreTwoWalls) {
  LinesWorld world;
  world.edges = {{{5.0, -3.0}, {5.0, 0.5}}, {{5.05, 0.5}, {5.05, 2.5}}};
  const auto walls = walls_of(world);
  ASSERT_EQ(walls.size(), 2U);
  EXPECT_NEAR(walls[0].center_m.x(), 5.0, 0.01);
  EXPECT_NEAR(walls[1].center_m.x(), 5.05, 0.01);
  EXPECT_FALSE(walls[1].start_seen) << "the wall in front hides where it begins";
  world.edges[1] = {{5.0, 0.5}, {5.0, 2.5}};
  EXPECT_EQ(walls_of(world).size(), 1U);
}

// A door 0.9 m wide, 9 m away in a wall that slants: three beams go through it. They are fewer than
// the strays that may lie on a wall, but what they met lies behind it.
TEST(LineExtractor, ADoorThatFewBeamsPassCutsAWall) {
  LinesWorld world;
  world.edges = {
      {{2.0, -1.5}, {8.6, -1.5}}, {{9.5, -1.5}, {14.0, -1.5}}, {{0.0, -6.0}, {20.0, -6.0}}};
  int on_line = 0;
  for (const ObservedWall& wall : walls_of(world)) {
    if (std::abs(wall.center_m.y() + 1.5) > 0.1) continue;
    ++on_line;
    EXPECT_TRUE(wall.end_m.x() < 8.9 || wall.start_m.x() > 9.2) << wall.end_m.transpose();
  }
  EXPECT_GE(on_line, 1);
}

// The wall in front ends there, and hides where the other one begins or ends.
TEST(LineExtractor, OfTwoSteppedWallsTheOneBehindHasAHiddenEnd) {
  LinesWorld world;
  world.edges = {{{5.0, -3.0}, {5.0, 0.5}}, {{5.05, 0.5}, {5.05, 2.5}}};
  auto walls = walls_of(world);
  ASSERT_EQ(walls.size(), 2U);
  EXPECT_TRUE(walls[0].end_seen);
  EXPECT_FALSE(walls[1].start_seen);
  world.edges = {{{5.05, -3.0}, {5.05, 0.5}}, {{5.0, 0.5}, {5.0, 2.5}}};
  walls = walls_of(world);
  ASSERT_EQ(walls.size(), 2U);
  EXPECT_FALSE(walls[0].end_seen);
  EXPECT_TRUE(walls[1].start_seen);
}

LinesScan exact_scan(const LinesWorld& world) {
  std::mt19937 random(1);
  LinesLaser laser;
  laser.range_sigma_m = 0.0;
  return testing::take_scan(world, laser, Pose2{}, random);
}

// A true end lies anywhere up to the next beam: half a beam farther on average.
TEST(LineExtractor, ASeenEndLiesHalfABeamBeyondTheLastPoint) {
  LinesWorld world;
  world.edges = {{{3.0, -2.0}, {3.0, 1.5}}, {{3.0, 1.5}, {1.5, 1.5}}};  // a corner
  LinesScan taken = exact_scan(world);
  LineExtractor extractor{LineExtractorOptions{}};
  const auto walls = extractor.extract(taken.scan);
  ASSERT_EQ(walls.size(), 2U);
  ASSERT_TRUE(walls[0].end_seen);
  const auto hit_m = [&](int beam) {
    return taken.scan.beams[static_cast<std::size_t>(beam)].hit_m;
  };
  const int last = walls[0].last_beam;
  const double spacing_m = (hit_m(last) - hit_m(last - 1)).norm();
  EXPECT_NEAR(walls[0].along().dot(walls[0].end_m - hit_m(last)), 0.5 * spacing_m, 1e-3);
}

// The edge of something in front gives one echo between the two surfaces.
TEST(LineExtractor, ASingleEchoBesideAnEndIsNoCorner) {
  LinesWorld world;
  world.edges = {{{5.0, -3.0}, {5.0, 1.0}}, {{3.0, 0.61}, {3.0, 2.0}}};
  LinesScan taken = exact_scan(world);
  LineExtractor extractor{LineExtractorOptions{}};
  const int last = extractor.extract(taken.scan)[0].last_beam;
  Beam& echo = taken.scan.beams[static_cast<std::size_t>(last) + 1];
  ASSERT_LT(echo.hit_m.x(), 3.01) << "the surface in front";
  const double scale = (5.0 - 0.105) / echo.hit_m.x();
  echo.hit_m *= scale;
  echo.range_m *= scale;
  const auto walls = extractor.extract(taken.scan);
  ASSERT_GE(walls.size(), 1U);
  ASSERT_EQ(walls[0].last_beam, last);
  EXPECT_FALSE(walls[0].end_seen);
}

// A wall beside the robot, seen at a grazing angle: across it the bearings' error counts most.
TEST(LineExtractor, BearingNoiseMakesAGrazedWallLessCertain) {
  LinesWorld world;
  world.edges = {{{1.0, -1.0}, {9.0, -1.0}}};
  LinesScan taken = exact_scan(world);
  const auto sigma_m = [&](double bearing_sigma_rad) {
    taken.scan.bearing_sigma_rad = bearing_sigma_rad;
    LineExtractor extractor{LineExtractorOptions{}};
    return extractor.extract(taken.scan)[0].across_sigma_m;
  };
  EXPECT_GT(sigma_m(0.01), 3.0 * sigma_m(1e-6));
}

}  // namespace
}  // namespace marco::slam
