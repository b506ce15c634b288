#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "mapping3d/surface/scene_smoothing.hpp"
#include "tests/unit/mapping3d_surface/box_world.hpp"

namespace marco::mapping3d {
namespace {

using testing::Box;
using testing::kRoom;
using testing::smoothed;
using testing::Sweep;

/// A real laser's noise: that of the directions weighs more than that of the ranges.
Sweep shaken() {
  Sweep by;
  by.sigma_m = 0.004;
  by.direction_sigma_rad = 0.004;
  return by;
}

TEST(SceneWindows, FitThePlaneOfLeastSquares) {
  const ScenePoints scene = testing::sweep(kRoom, {}, Sweep{});
  const SceneWindows windows(scene);
  for (const auto& [row, column] : {std::pair{12, 30}, {30, 60}, {55, 100}, {2, 118}}) {
    const WindowReach reach{2, 3};
    Eigen::MatrixX3d beams(0, 3);
    Eigen::VectorXd inverse(0);
    for (int y = row - 2; y <= row + 2; ++y) {
      for (int x = column - 3; x <= std::min(120, column + 3); ++x) {
        const Eigen::Vector3d p =
            scene.points_m[windows.at(y, x)].cast<double>() - windows.centre_m();
        beams.conservativeResize(beams.rows() + 1, 3);
        inverse.conservativeResize(beams.rows());
        beams.bottomRows(1) = p.normalized().transpose();
        inverse(inverse.size() - 1) = 1.0 / p.norm();
      }
    }
    const WindowPlane plane = windows.fit(row, column, reach);
    const Eigen::Vector3d m = beams.colPivHouseholderQr().solve(inverse);
    const auto count = static_cast<double>(inverse.size());
    EXPECT_LT((plane.m - m).norm(), 1e-6 * m.norm());  // of sums of 1e4 beams, in double
    EXPECT_NEAR(plane.residual, (beams * m - inverse).norm() / std::sqrt(count - 3.0), 1e-7);
    EXPECT_NEAR(plane.by_range, inverse.array().pow(4).mean(), 1e-9);
    const Eigen::ArrayXd along = (beams * m).array();
    EXPECT_NEAR(plane.by_direction, m.squaredNorm() - along.square().mean(), 1e-6);
    EXPECT_LT((plane.covariance * beams.transpose() * beams - Eigen::Matrix3d::Identity()).norm(),
              1e-5);
  }
}

TEST(SceneWindows, SpanTheSameAngleInBothDirections) {
  Sweep by;
  by.rows = 241;
  by.tilt_step_deg = 0.3;  // a fifth of what lies between columns
  const ScenePoints scene = testing::sweep(kRoom, {}, by);
  const SceneWindows windows(scene);
  const WindowReach straight = windows.reach(120, 60, SceneWindows::kLargest);
  EXPECT_NEAR(straight.rows * 0.3, straight.columns * 1.5, 0.75);
  EXPECT_GE(straight.rows, 5);
  // To the side the rows lie closer.
  const WindowReach aside = windows.reach(120, 20, SceneWindows::kLargest);
  EXPECT_NEAR(aside.rows * 0.3 * std::cos(deg_to_rad(60.0)), straight.rows * 0.3, 0.3);
  // The beams to the right lie on the axis of the tilt: all rows see the same.
  EXPECT_EQ(windows.reach(120, 0, 1).rows, 120);
  EXPECT_EQ(windows.reach(120, 1, 3).rows, 120);
}

TEST(BeamNoise, IsLearnedInItsTwoParts) {
  for (const double direction_sigma_rad : {0.0, 0.001, 0.004}) {
    Sweep by = shaken();
    by.direction_sigma_rad = direction_sigma_rad;
    const BeamNoise noise = learn_noise({testing::sweep(kRoom, {}, by)});
    // The lower third of windows of 49 beams lies 5 % below their mean.
    EXPECT_NEAR(noise.range_m, 0.004, 0.0005) << direction_sigma_rad;
    EXPECT_NEAR(noise.direction_rad, direction_sigma_rad, 0.15 * direction_sigma_rad + 0.0003);
  }
}

TEST(BeamNoise, OfNoSceneIsTheLimit) {
  const SmoothingOptions options;
  const BeamNoise noise = learn_noise(std::vector<ScenePoints>{}, options);
  EXPECT_EQ(noise.range_m, options.max_sigma_m);
  EXPECT_EQ(noise.direction_rad, 0.0);
}

TEST(SceneSmoothing, TakesTheNoiseOffWallsAndFindsItsSize) {
  const SmoothScene scene = smoothed(testing::sweep(kRoom, {}, Sweep{}));
  EXPECT_NEAR(scene.noise.range_m, 0.010, 0.001);
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < scene.points_m.size(); ++i) {
    if (scene.kinds[i] != SmoothScene::Kind::plane) continue;
    const double error = testing::distance(kRoom, {}, scene.points_m[i].cast<double>());
    squares += error * error;
    ++count;
    EXPECT_LT(scene.normals[i].dot(scene.points_m[i] - scene.origins_m[0]), 0.0F);
  }
  EXPECT_GT(count, scene.points_m.size() * 9 / 10);
  // A 7 x 7 window leaves a seventh of 10 mm in the middle of a wall, 2.6 times that at its edge.
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 0.003);
}

// Without the noise of the directions a floor fails the plane test where it is seen at a slant.
TEST(SceneSmoothing, FindsAPlaneAtASlant) {
  const Box hall{{-12, -12, 0}, {12, 12, 3}};
  Sweep by = shaken();
  by.rows = 40;
  by.tilt_step_deg = 0.5;
  by.tilt_first_deg = -24.0;
  const ScenePoints scene = testing::sweep(hall, {}, by);
  const BeamNoise learned = learn_noise({scene});
  const auto share_on_plane = [&](const BeamNoise& noise) {
    const SmoothScene smooth_scene = smooth(scene, noise);
    std::size_t slanted = 0, on_plane = 0;
    for (std::size_t i = 0; i < scene.points_m.size(); ++i) {
      const Eigen::Vector3f& p = scene.points_m[i];
      if (std::abs(p.z()) > 0.2F || p.head<2>().norm() < 1.5F || p.head<2>().norm() > 5.0F)
        continue;
      ++slanted;
      on_plane += smooth_scene.kinds[i] == SmoothScene::Kind::plane ? 1 : 0;
    }
    EXPECT_GT(slanted, 1000U);
    return static_cast<double>(on_plane) / static_cast<double>(slanted);
  };
  EXPECT_GT(share_on_plane(learned), 0.98);
  EXPECT_LT(share_on_plane({learned.range_m, 0.0}), 0.7);
}

}  // namespace
}  // namespace marco::mapping3d
