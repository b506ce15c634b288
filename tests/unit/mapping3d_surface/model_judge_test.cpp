#include "tools/evaluate/model_judge.hpp"
#include "tools/evaluate/model_fit.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/matchers.hpp"

namespace marco {
namespace {

// An L of a room with two crates: alike from no two sides.
sim::World world() {
  sim::World world;
  world.add_quad({Eigen::Vector3d(0, 0, 0), {6, 0, 0}, {6, 4, 0}, {0, 4, 0}}, sim::Material::plain);
  world.add_box({3, 0, 1.2}, {6, 0.1, 2.4}, 0.0, sim::Material::plain);
  world.add_box({3, 4, 1.2}, {6, 0.1, 2.4}, 0.0, sim::Material::plain);
  world.add_box({0, 2, 1.2}, {0.1, 4, 2.4}, 0.0, sim::Material::plain);
  world.add_box({6, 2, 1.2}, {0.1, 4, 2.4}, 0.0, sim::Material::plain);
  world.add_box({1.2, 1.0, 0.5}, {0.8, 0.6, 1.0}, 0.3, sim::Material::plain);
  world.add_box({4.9, 3.1, 0.8}, {0.5, 0.9, 1.6}, 0.0, sim::Material::plain);
  return world;
}

TriangleMesh as_mesh(const sim::World& from) {
  TriangleMesh mesh;
  mesh.vertices_m = from.vertices_m;
  mesh.triangles = from.triangles;
  return mesh;
}

TEST(ModelJudge, FindsAModelThatLiesAnywhere) {
  const sim::RayCaster rays(world());
  const TriangleMesh truth = as_mesh(world());
  for (const double heading_deg : {-140.0}) {
    const Pose3 model_from_world =
        make_pose3({-2.3, 1.7, 0.03}, 0.004, -0.003, deg_to_rad(heading_deg));
    const ModelFit fit = find_model(moved(truth, model_from_world), rays);
    EXPECT_TRUE((fit.world_from_model * model_from_world).isApprox(Pose3::Identity(), 1e-3))
        << (fit.world_from_model * model_from_world).matrix();
    EXPECT_LT(fit.rms_m, 0.001);
  }
}

TEST(ModelJudge, MeasuresWhatIsOffMissingAndDouble) {
  const sim::RayCaster rays(world());
  std::vector<BeamEnd> beams;  // all over the floor's left half, and the middle of the crate's top
  for (double x = 2.0; x < 4.0; x += 0.05) {
    for (double y = 1.0; y < 3.0; y += 0.05) {
      const auto hit = rays.cast(Eigen::Vector3d(x, y, 2.0).cast<float>(), {0, 0, -1}, 10);
      ASSERT_TRUE(hit);
      beams.push_back({Eigen::Vector3d(x, y, 2.0 - static_cast<double>(hit->range_m)).cast<float>(),
                       hit->normal, hit->triangle});
    }
  }
  TriangleMesh
      model;  // the floor 10 mm too high, for x < 3 only; and again 25 mm below, for x < 2.5
  const auto add = [&](float x, float z) {
    const auto first = static_cast<uint32_t>(model.vertices_m.size());
    model.vertices_m.insert(model.vertices_m.end(),
                            {{1.8F, 0.8F, z}, {x, 0.8F, z}, {x, 3.2F, z}, {1.8F, 3.2F, z}});
    model.triangles.push_back({first, first + 1, first + 2});
    model.triangles.push_back({first, first + 2, first + 3});
  };
  add(3.0F, 0.010F);
  add(2.5F, -0.015F);
  const ModelJudgement found = judge_model(model, rays, beams);
  // 1.2 m at 10 mm, 0.7 m at 15 mm.
  EXPECT_NEAR(found.error.rms_m, std::sqrt((1.2 * 1e-4 + 0.7 * 2.25e-4) / 1.9), 1e-4);
  EXPECT_NEAR(found.error.max_m, 0.015, 1e-5);
  ASSERT_TRUE(found.coverage);
  EXPECT_NEAR(found.coverage->covered, 0.5, 0.03);
  ASSERT_TRUE(found.sheets);
  EXPECT_NEAR(found.sheets->max_m, 0.025, 1e-4);
  EXPECT_NEAR(
      static_cast<double>(found.sheets->too_far) / static_cast<double>(found.sheets->places), 0.5,
      0.05);
}

TEST(ModelJudge, ATrueModelHasNoError) {
  const sim::RayCaster rays(world());
  const ModelJudgement found = judge_model(as_mesh(world()), rays, {});
  EXPECT_LT(found.error.max_m, 1e-3);  // floats, squared twice over six metres
  EXPECT_LT(found.error.rms_m, 1e-4);
  EXPECT_GT(found.error.count, 100000U);
  EXPECT_FALSE(found.coverage);
}

}  // namespace
}  // namespace marco
