#include <gtest/gtest.h>

#include <algorithm>

#include "common/mesh_samples.hpp"
#include "tests/unit/mapping3d_surface/box_world.hpp"

namespace marco::mapping3d {
namespace {

using testing::Box;
using testing::coarse;
using testing::kRoom;
using testing::Sweep;

constexpr double kLegM = 0.03;
const Box kLeg{{1.0, 0.2, 0.0}, {1.0 + kLegM, 0.2 + kLegM, 0.7}};
const Box kAboveFloor{{1.0, 0.2, 0.1}, kLeg.high};

// Beams 6 mm apart at a metre, so that several hit the leg; voxels wider than it.
ScenePoints at_a_leg(unsigned seed, const std::vector<Box>& things) {
  Sweep from;
  from.rows = 40;
  from.columns = 541;
  from.sigma_m = 0.003;
  from.seed = seed;
  return testing::sweep(kRoom, things, from);
}

double area_at(const TriangleMesh& mesh, const Box& box, double near_m) {
  constexpr float kEachM2 = 1e-5F;
  std::size_t samples = 0;
  for_each_sample(mesh, kEachM2, [&](const Eigen::Vector3f& at, std::size_t) {
    const Eigen::Vector3d p = at.cast<double>();
    samples += ((p - box.low).array() > -near_m).all() && ((box.high - p).array() > -near_m).all();
  });
  return static_cast<double>(samples) * static_cast<double>(kEachM2);
}

TEST(SmallPieces, AThingThinnerThanAVoxelIsInTheModel) {
  const TriangleMesh model = fuse({at_a_leg(1, {kLeg})}, coarse());
  ASSERT_EQ(model.normals.size(), model.vertices_m.size());
  // Its front and the side that the sensor sees, as far as the sweep reaches.
  EXPECT_GT(area_at(model, kAboveFloor, 0.01), 0.8 * 0.6 * kLegM);
}

TEST(SmallPieces, ThreeScenesAddItOnce) {
  const TriangleMesh once = fuse({at_a_leg(1, {kLeg})}, coarse());
  const TriangleMesh often =
      fuse({at_a_leg(1, {kLeg}), at_a_leg(2, {kLeg}), at_a_leg(3, {kLeg})}, coarse());
  EXPECT_LT(area_at(often, kAboveFloor, 0.03), 1.4 * area_at(once, kAboveFloor, 0.03));
}

TEST(SmallPieces, WhatOtherScenesSeeThroughIsGone) {
  const ScenePoints with = at_a_leg(1, {kLeg}), without = at_a_leg(2, {});
  EXPECT_LT(area_at(fuse({with, without}, coarse()), kAboveFloor, 0.03), 1e-4);
  EXPECT_LT(area_at(fuse({without, with}, coarse()), kAboveFloor, 0.03), 1e-4);
}

// A rod at bearing 0, thinner than the beams are apart.
TEST(SmallPieces, AThingThatOneBeamOfEachRowHitsIsAStrip) {
  const Box rod{{1.0, -0.01, 0.0}, {1.02, 0.01, 0.7}}, above_floor{{1.0, -0.01, 0.1}, rod.high};
  const double spacing_m = deg_to_rad(1.5);
  for (const unsigned seed : {1U, 2U, 3U}) {
    Sweep from;
    from.sigma_m = 0.003;
    from.seed = seed;
    const TriangleMesh model = fuse({testing::sweep(kRoom, {rod}, from)}, coarse());
    const double area_m2 = area_at(model, above_floor, 0.015);
    EXPECT_GT(area_m2, 0.8 * 0.6 * 0.5 * spacing_m);
    EXPECT_LT(area_m2, 1.2 * 0.6 * 0.5 * spacing_m);
    for (std::size_t i = 0; i < model.vertices_m.size(); ++i) {
      const Eigen::Vector3d p = model.vertices_m[i].cast<double>();
      if (testing::distance({{-9, -9, -9}, {9, 9, 9}}, {rod}, p) > 0.02) continue;
      EXPECT_GT(model.normals[i].dot(Eigen::Vector3f(0, 0, 0.6F) - model.vertices_m[i]), 0.0F);
    }
  }
}

class MixedRange : public ::testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Beams, MixedRange, ::testing::Values(1, 3));

TEST_P(MixedRange, IsNotAThing) {
  const Box cupboard{{1.0, 0.2, 0.0}, {1.2, 1.9, 2.0}};
  ScenePoints scene = at_a_leg(1, {cupboard});
  const auto range_m = [&](std::size_t i) {
    return (scene.points_m[i] - scene.origins_m[i / scene.columns]).norm();
  };
  // So many beams of each row at its edge return what lies between it and the wall, at equal
  // ranges.
  std::size_t edges = 0;
  for (std::size_t row = 0; row < scene.rows; ++row) {
    for (std::size_t column = 10; column + 10 < scene.columns; ++column) {
      const std::size_t i = scene.index(row, column);
      if (range_m(i) < range_m(i + 1) + 0.8F) continue;
      ++edges;
      for (std::size_t k = i + 1 - GetParam(); k <= i; ++k) {
        const Eigen::Vector3f& origin = scene.origins_m[row];
        const Eigen::Vector3f way = (scene.points_m[k] - origin).normalized();
        scene.points_m[k] = origin + 1.7F * way;
      }
      break;
    }
  }
  ASSERT_GT(edges, 20U);
  const TriangleMesh model = fuse({scene}, coarse());
  double farthest_m = 0.0;
  std::size_t samples = 0, off = 0;
  for_each_sample(model, 1e-4F, [&](const Eigen::Vector3f& at, std::size_t) {
    const double error_m = testing::distance(kRoom, {cupboard}, at.cast<double>());
    ++samples;
    off += error_m > 0.2;
    farthest_m = std::max(farthest_m, error_m);
  });
  ASSERT_GT(samples, 1000U);
  EXPECT_EQ(off, 0U) << "up to " << farthest_m << " m";
}

}  // namespace
}  // namespace marco::mapping3d
