#include <gtest/gtest.h>
#include <cmath>
#include <random>

#include "common/mesh_samples.hpp"
#include "mapping3d/surface/surface_model.hpp"
#include "mapping3d/surface/welded.hpp"
#include "tests/unit/mapping3d_surface/box_world.hpp"

namespace marco::mapping3d {
namespace {

using testing::Box;
using testing::coarse;
using testing::kRoom;
using testing::smoothed;
using testing::Sweep;

struct Errors {
  double rms_m = 0.0;
  double p99_m = 0.0;
};

Errors errors_of(const TriangleMesh& mesh, const std::vector<Box>& obstacles) {
  std::vector<double> all;
  double squares = 0.0;
  for_each_sample(mesh, 1e-3F, [&](const Eigen::Vector3f& p, std::size_t) {
    all.push_back(testing::distance(kRoom, obstacles, p.cast<double>()));
    squares += all.back() * all.back();
  });
  if (all.empty()) return {};
  std::sort(all.begin(), all.end());
  return {std::sqrt(squares / static_cast<double>(all.size())), all[all.size() * 99 / 100]};
}

// Area of the triangles whose middles lie in a box and that face `facing`.
double area_in(const TriangleMesh& mesh, const Box& box, const Eigen::Vector3f& facing) {
  double area_m2 = 0.0;
  for (const auto& t : mesh.triangles) {
    const auto& v = mesh.vertices_m;
    const Eigen::Vector3f twice = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
    const Eigen::Vector3d at = ((v[t[0]] + v[t[1]] + v[t[2]]) / 3.0F).cast<double>();
    if (twice.dot(facing) > 0.7F * twice.norm() && (at - box.low).minCoeff() > 0 &&
        (box.high - at).minCoeff() > 0) {
      area_m2 += 0.5 * static_cast<double>(twice.norm());
    }
  }
  return area_m2;
}

/// Two rows of beams on a wall and one on the floor before it, three beams each, an eightieth of
/// their range apart.
SmoothScene foot_of_a_wall(float range_m, SmoothScene::Kind kind = SmoothScene::Kind::plane) {
  SmoothScene scene;
  scene.rows = scene.columns = 3;
  const float step_m = range_m / 80.0F;
  for (int row = 0; row < 3; ++row) {
    scene.origins_m.emplace_back(0.0F, 0.0F, 4.0F * step_m);
    for (int column = 0; column < 3; ++column) {
      const bool wall = row < 2;
      scene.points_m.emplace_back(wall ? range_m : range_m - 0.4F * step_m,
                                  step_m * static_cast<float>(1 - column),
                                  step_m * static_cast<float>(2 - row));
      scene.normals.emplace_back(wall ? -1.0F : 0.0F, 0.0F, wall ? 0.0F : 1.0F);
      scene.kinds.push_back(kind);
      scene.sigmas_m.push_back(0.01F);
    }
  }
  return scene;
}

// Far away the cut across a corner would lie decimetres before the wall that another scene sees.
TEST(Facets, CutACornerOnlyWhereTheCutIsShort) {
  EXPECT_EQ(facets(foot_of_a_wall(10.0F)).size(), 8U);
  EXPECT_EQ(facets(foot_of_a_wall(20.0F)).size(), 4U);
  FacetOptions any;
  any.max_corner_m = 0.8;
  EXPECT_EQ(facets(foot_of_a_wall(20.0F), any).size(), 8U);
}

// What is on no plane is known at its beams alone: without facets it would be lost.
TEST(Facets, JoinLooseBeamsFartherThanACorner) {
  EXPECT_EQ(facets(foot_of_a_wall(20.0F, SmoothScene::Kind::loose)).size(), 8U);
  EXPECT_EQ(facets(foot_of_a_wall(40.0F, SmoothScene::Kind::loose)).size(), 0U);
}

// Two windows of one plane differ by their noise; an edge differs by more.
TEST(Facets, JoinPlanesWithinTheirNoise) {
  SmoothScene scene = foot_of_a_wall(20.0F);
  scene.points_m[4].x() += 0.08F;
  const std::size_t apart = facets(scene).size();
  for (float& sigma_m : scene.sigmas_m) sigma_m = 0.03F;
  EXPECT_LT(apart, 4U);
  EXPECT_EQ(facets(scene).size(), 4U);
}

TEST(Facets, ReachAlongAFloorButNotAcrossAnEdge) {
  const std::vector<Box> crate{{{1.0, -0.4, 0.0}, {1.4, 0.4, 0.8}}};
  const SmoothScene scene = smoothed(testing::sweep(kRoom, crate, Sweep{}));
  double longest_m = 0.0, worst_m = 0.0;
  for (const auto& t : facets(scene)) {
    for (std::size_t i = 0; i < 3; ++i) {
      longest_m = std::max(
          longest_m,
          static_cast<double>((scene.points_m[t[i]] - scene.points_m[t[(i + 1) % 3]]).norm()));
    }
    const Eigen::Vector3f middle =
        (scene.points_m[t[0]] + scene.points_m[t[1]] + scene.points_m[t[2]]) / 3.0F;
    worst_m = std::max(worst_m, testing::distance(kRoom, crate, middle.cast<double>()));
  }
  EXPECT_GT(longest_m, 0.15);  // the floor near the wall, 3 m away
  EXPECT_LT(worst_m, 0.06);    // a skin from the crate to the wall would hang 0.5 m off
}

TEST(Surface, ManyScenesMakeOneWallWithinTheNoise) {
  SurfaceModel model(coarse());
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Sweep by;
    by.seed = seed;
    by.heading_rad = 0.4 * seed;
    by.from.x() = -0.3 * seed;
    model.add(smoothed(testing::sweep(kRoom, {}, by)));
  }
  const TriangleMesh mesh = model.take_mesh();
  const Errors errors = errors_of(mesh, {});
  // Noise of 10 mm, smoothed to 3; a room's inner corners are cut by up to 0.35 voxel.
  EXPECT_LT(errors.rms_m, 0.004);
  EXPECT_LT(errors.p99_m, 0.018);
  // One sheet: the far wall's area is there once.
  const double wall_m2 = area_in(mesh, {{2.8, -1, 0.8}, {3.2, 1, 1.8}}, {-1, 0, 0});
  EXPECT_NEAR(wall_m2, 2.0, 0.06);
  EXPECT_EQ(area_in(mesh, {{2.5, -1, 0.8}, {3.5, 1, 1.8}}, {1, 0, 0}), 0.0);
}

TEST(Surface, AThinPlateSeenFromBothSidesKeepsBoth) {
  // 3 cm thick, at voxels of 2.5 cm.
  const std::vector<Box> plate{{{0.0, -0.5, 0.2}, {0.03, 0.5, 1.2}}};
  std::vector<ScenePoints> scenes;
  for (const double side : {-1.0, 1.0}) {
    Sweep by;
    by.from = {1.4 * side, 0.1, 0.6};
    by.heading_rad = side > 0 ? 3.14159 : 0.0;
    scenes.push_back(testing::sweep(kRoom, plate, by));
  }
  SurfaceOptions options;
  options.voxel_m = 0.025;
  const TriangleMesh mesh = fuse(scenes, options);
  const Box around{{-0.1, -0.4, 0.3}, {0.13, 0.4, 1.1}};
  EXPECT_NEAR(area_in(mesh, around, {-1, 0, 0}), 0.64, 0.03);
  EXPECT_NEAR(area_in(mesh, around, {1, 0, 0}), 0.64, 0.03);
  for_each_sample(mesh, 1e-4F, [&](const Eigen::Vector3f& p, std::size_t) {
    if ((p.cast<double>() - around.low).minCoeff() < 0 ||
        (around.high - p.cast<double>()).minCoeff() < 0) {
      return;
    }
    EXPECT_LT(testing::distance(kRoom, plate, p.cast<double>()),
              0.018);  // nothing between or beside
  });
}

TEST(Surface, WhatBeamsSeeThroughLaterIsGone) {
  const std::vector<Box> person{{{1.0, -0.2, 0.0}, {1.3, 0.2, 1.8}}};
  std::vector<ScenePoints> scenes{testing::sweep(kRoom, person, Sweep{})};
  for (unsigned seed = 2; seed <= 3; ++seed) {
    Sweep by;
    by.seed = seed;
    scenes.push_back(testing::sweep(kRoom, {}, by));
  }
  const Box there{{0.9, -0.3, 0.1}, {1.4, 0.3, 1.3}};
  const TriangleMesh mesh = fuse(scenes, coarse());
  // Of 0.48 m2 of its front all but patches that too few beams crossed twice.
  EXPECT_LT(area_in(mesh, there, {-1, 0, 0}), 0.1);
  EXPECT_LT(errors_of(mesh, {}).p99_m, 0.05);
  // Seen in one scene alone it stays.
  EXPECT_GT(area_in(fuse({scenes[0]}, coarse()), there, {-1, 0, 0}), 0.3);
  // And the order does not matter.
  const TriangleMesh turned = fuse({scenes[2], scenes[0], scenes[1]}, coarse());
  EXPECT_NEAR(static_cast<double>(turned.triangles.size()),
              static_cast<double>(mesh.triangles.size()),
              0.01 * static_cast<double>(mesh.triangles.size()));
  EXPECT_LT(area_in(turned, there, {-1, 0, 0}), 0.1);
}

TEST(Surface, HasOneVertexAtAPlace) {
  std::vector<ScenePoints> scenes;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Sweep sweep;
    sweep.seed = seed;
    scenes.push_back(testing::sweep(kRoom, {{{1.0, -0.2, 0.0}, {1.3, 0.2, 1.8}}}, sweep));
  }
  EXPECT_FALSE(welded(fuse(scenes, coarse())).has_value());
}

TEST(Surface, UnknownStaysOpen) {
  ScenePoints scene = testing::sweep(kRoom, {}, Sweep{});
  // A window of missing beams in the wall ahead, and the half room behind was never looked at.
  for (std::size_t row = 20; row < 40; ++row) {
    for (std::size_t column = 50; column < 70; ++column) scene.valid[scene.index(row, column)] = 0;
  }
  const TriangleMesh mesh = fuse({scene}, coarse());
  const double tall_m = 3.0 * (std::tan(deg_to_rad(11.8)) + std::tan(deg_to_rad(11)));
  EXPECT_GT(tall_m, 1.0);
  EXPECT_EQ(area_in(mesh, {{2.8, -0.5, 0.3}, {3.2, 0.4, 0.9}}, {-1, 0, 0}), 0.0);
  EXPECT_EQ(area_in(mesh, {{-3.5, -3, -1}, {-0.5, 3, 3}}, {1, 0, 0}), 0.0);
}

TEST(Surface, OfNothingIsNothing) {
  EXPECT_TRUE(fuse(std::vector<ScenePoints>{}).triangles.empty());
  ScenePoints blind = testing::sweep(kRoom, {}, Sweep{});
  std::fill(blind.valid.begin(), blind.valid.end(), uint8_t{0});
  EXPECT_TRUE(fuse({blind, ScenePoints{}}).triangles.empty());
  SurfaceOptions bad;
  bad.voxel_m = 0.0;
  EXPECT_THROW(SurfaceModel{bad}, std::invalid_argument);
}

TEST(Surface, NormalsFaceWhereItWasSeenFrom) {
  const TriangleMesh mesh = fuse({testing::sweep(kRoom, {}, Sweep{})}, coarse());
  ASSERT_EQ(mesh.normals.size(), mesh.vertices_m.size());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    EXPECT_NEAR(mesh.normals[i].norm(), 1.0F, 1e-4F);
    wrong += mesh.normals[i].dot(Eigen::Vector3f(0, 0, 0.6F) - mesh.vertices_m[i]) < 0.0F;
  }
  EXPECT_LT(wrong, mesh.normals.size() / 500);
}

TEST(PackedNormal, IsADirectionToADegree) {
  std::mt19937 random(11);
  std::normal_distribution<float> draw;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3f normal = Eigen::Vector3f(draw(random), draw(random), draw(random));
    EXPECT_GT(PackedNormal(normal).unpacked().dot(normal.normalized()), std::cos(0.0175F));
  }
  for (const Eigen::Vector3f& axis : {Eigen::Vector3f(0, 0, -1), Eigen::Vector3f(0, -1, 0)}) {
    EXPECT_TRUE(PackedNormal(axis).unpacked().isApprox(axis));
  }
  EXPECT_EQ(PackedNormal(Eigen::Vector3f::Zero()).unpacked(), Eigen::Vector3f::UnitZ());
}

}  // namespace
}  // namespace marco::mapping3d
