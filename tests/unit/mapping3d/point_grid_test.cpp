#include "mapping3d/clouds/point_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "mapping3d/clouds/scan_lines.hpp"
#include "tests/support/analytic_room.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::AnalyticRoom;

const Eigen::Vector3d kMiddle(-0.5, 0.3, 1.4);

Eigen::Vector3d direction_of(double azimuth_rad, double elevation_rad) {
  return {std::cos(azimuth_rad) * std::cos(elevation_rad),
          std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad)};
}

// In the scanner's frame, rounded to a millimetre as text files are.
Eigen::Vector3f seen(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction) {
  // A hair off the axes, so that no ray runs along a wall.
  const Eigen::Vector3d way = (direction + Eigen::Vector3d(1e-7, 2e-7, 3e-7)).normalized();
  const Eigen::Vector3d point_m = AnalyticRoom::range_m(from_m, way) * way;
  return (1000.0 * point_m).array().round().matrix().cast<float>() * 1e-3F;
}

struct Span {
  double first_deg, step_deg;
  int count;
};

PointCloud scan(const Span& azimuths, const Span& elevations, std::mt19937& random) {
  PointCloud cloud;
  for (int column = 0; column < azimuths.count; ++column) {
    for (int row = 0; row < elevations.count; ++row) {
      cloud.points_m.push_back(seen(
          kMiddle, direction_of(deg_to_rad(azimuths.first_deg + azimuths.step_deg * column),
                                deg_to_rad(elevations.first_deg + elevations.step_deg * row))));
    }
  }
  std::shuffle(cloud.points_m.begin(), cloud.points_m.end(), random);
  return cloud;
}

double valid_part(const ScenePoints& scene) {
  std::size_t valid = 0;
  for (const uint8_t one : scene.valid) valid += one;
  return static_cast<double>(valid) / static_cast<double>(scene.valid.size());
}

// The part of neighbours in a row and in a column that lie side by side: within two steps.
double neighbouring_part(const ScenePoints& scene, double step_rad) {
  std::size_t pairs = 0, near = 0;
  const auto compare = [&](std::size_t a, std::size_t b) {
    if (scene.valid[a] == 0 || scene.valid[b] == 0) return;
    const Eigen::Vector3f p = scene.points_m[a], q = scene.points_m[b];
    ++pairs;
    const auto apart_rad = static_cast<double>(std::atan2(p.cross(q).norm(), p.dot(q)));
    near += apart_rad < 2.0 * step_rad ? 1 : 0;
  };
  for (std::size_t row = 0; row + 1 < scene.rows; ++row) {
    for (std::size_t column = 0; column + 1 < scene.columns; ++column) {
      compare(scene.index(row, column), scene.index(row, column + 1));
      compare(scene.index(row, column), scene.index(row + 1, column));
    }
  }
  return static_cast<double>(near) / static_cast<double>(pairs);
}

class PointGrid : public ::testing::Test {
 protected:
  std::mt19937 random_{7};
};

TEST_F(PointGrid, FindsTheLinesOfAScannerThatStands) {
  const PointCloud cloud = scan({-180.0, 0.5, 720}, {-60.0, 0.5, 290}, random_);
  const GriddedCloud found = grid(cloud);
  EXPECT_EQ(found.scene.rows, 290U);
  EXPECT_EQ(found.scene.columns, 721U);  // closed by the first one
  EXPECT_GT(valid_part(found.scene), 0.999);
  EXPECT_GT(neighbouring_part(found.scene, deg_to_rad(0.5)), 0.999);
  EXPECT_LT(found.layered, 0.001);
  EXPECT_EQ(found.scene.points_m.front(), found.scene.points_m[720]);
  ASSERT_NE(found.point_of[5], GriddedCloud::kNoPoint);
  EXPECT_EQ(cloud.points_m[found.point_of[5]], found.scene.points_m[5]);
}

TEST_F(PointGrid, FindsTheRingsOfALaserThatSpins) {
  const GriddedCloud found = grid(scan({-180.0, 0.2, 1800}, {-15.0, 2.0, 16}, random_));
  EXPECT_EQ(found.scene.rows, 16U);
  EXPECT_EQ(found.scene.columns, 1801U);
  EXPECT_GT(valid_part(found.scene), 0.999);
}

// As by a rotating mirror that nobody synchronized.
TEST_F(PointGrid, EvenStepsServeBeamsThatLieAnywhere) {
  std::uniform_real_distribution<double> part(0.0, 1.0);
  PointCloud cloud;
  for (int i = 0; i < 60000; ++i) {
    cloud.points_m.push_back(seen(kMiddle, direction_of(2.0 * std::numbers::pi * part(random_),
                                                        std::asin(-0.8 + 1.7 * part(random_)))));
  }
  const GriddedCloud found = grid(cloud);
  EXPECT_GT(valid_part(found.scene), 0.93);
  EXPECT_LT(found.layered, 0.05);
  std::size_t taken = 0;
  for (const uint32_t point : found.point_of) taken += point != GriddedCloud::kNoPoint ? 1 : 0;
  EXPECT_GT(taken, cloud.points_m.size() / 3);
}

TEST_F(PointGrid, AScanOfAHalfCircleIsNotCutInTwo) {
  const GriddedCloud found = grid(scan({100.0, 0.5, 320}, {-40.0, 0.5, 160}, random_));
  EXPECT_EQ(found.scene.rows, 160U);
  EXPECT_EQ(found.scene.columns, 320U);
  EXPECT_GT(neighbouring_part(found.scene, deg_to_rad(0.5)), 0.999);
}

TEST_F(PointGrid, AnOrganizedCloudKeepsItsRows) {
  PointCloud cloud;
  cloud.rows = 40;
  for (int i = 0; i < 40 * 50; ++i) {
    const auto at = direction_of(deg_to_rad(i % 50), deg_to_rad(i / 50 - 20));
    cloud.points_m.push_back(i % 7 == 0 ? Eigen::Vector3f::Constant(std::nanf(""))
                                        : seen(kMiddle, at));
  }
  const GriddedCloud found = grid(cloud);
  ASSERT_EQ(found.scene.rows, 40U);
  ASSERT_EQ(found.scene.columns, 50U);
  for (std::size_t i = 0; i < found.scene.valid.size(); ++i) {
    EXPECT_EQ(found.scene.valid[i], i % 7 == 0 ? 0 : 1);
  }
}

TEST_F(PointGrid, RowsThatGoAllAroundAreClosed) {
  PointCloud cloud;  // the scanner turns, and each row is a fan from below to above
  cloud.rows = 360;
  for (int i = 0; i < 360 * 100; ++i) {
    cloud.points_m.push_back(
        seen(kMiddle, direction_of(deg_to_rad(i / 100), deg_to_rad(i % 100 - 50))));
  }
  const GriddedCloud found = grid(cloud);
  EXPECT_EQ(found.scene.rows, 361U);
  EXPECT_EQ(found.scene.columns, 100U);
  EXPECT_EQ(found.scene.points_m[found.scene.index(360, 3)], found.scene.points_m[3]);
}

// Five rooms, each scanned from its middle.
TEST_F(PointGrid, ScansOfSeveralPlacesInOneFileAreTold) {
  const PointCloud one = scan({-180.0, 0.5, 720}, {-60.0, 0.5, 240}, random_);
  PointCloud merged = one;
  for (const Eigen::Vector3f& to : {Eigen::Vector3f(9, 0, 0), Eigen::Vector3f(-9, 0, 0),
                                    Eigen::Vector3f(0, 7, 0), Eigen::Vector3f(0, -7, 0)}) {
    for (const Eigen::Vector3f& point_m : one.points_m) merged.points_m.push_back(point_m + to);
  }
  EXPECT_GT(grid(merged).layered, 0.2);
}

TEST_F(PointGrid, ThinsOutMillionsOfPoints) {
  const PointCloud cloud = scan({-180.0, 0.15, 2400}, {-60.0, 0.15, 900}, random_);
  const GriddedCloud found = grid(cloud);
  EXPECT_LE(found.point_of.size(), 2'010'000U);
  EXPECT_GT(found.point_of.size(), 500'000U);
  EXPECT_GT(valid_part(found.scene), 0.99);
}

TEST_F(PointGrid, NothingSeenIsNoScene) { EXPECT_EQ(grid({}).scene.rows, 0U); }

TEST(ScanLines, UnevenLinesAreFoundAndSectorsAreNone) {
  std::mt19937 random(3);
  std::normal_distribution<double> jitter(0.0, 1e-4);
  std::vector<double> angles_rad;
  // Two groups of rings, as a laser for the road has them, and a sector without any.
  for (int ring = 0; ring < 32; ++ring) {
    const double at_rad = deg_to_rad(ring < 16 ? -25.0 + 0.5 * ring : 3.0 + 0.33 * ring);
    for (int i = 0; i < 200; ++i) angles_rad.push_back(at_rad + jitter(random));
  }
  const std::vector<double> lines = find_lines(angles_rad);
  ASSERT_EQ(lines.size(), 32U);
  EXPECT_NEAR(lines[3], deg_to_rad(-23.5), 1e-4);
  std::vector<double> anywhere;
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (int i = 0; i < 5000; ++i) anywhere.push_back(part(random));
  EXPECT_TRUE(find_lines(anywhere).empty());
}

}  // namespace
}  // namespace marco::mapping3d
