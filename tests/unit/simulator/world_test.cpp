#include "simulator/world.hpp"

#include <gmock/gmock.h>

#include <random>

#include "lcm_tools/process/config.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "simulator/ray_caster.hpp"
#include "simulator/tour.hpp"

namespace marco::sim {
namespace {

using ::marco::testing::complaint;
using ::testing::HasSubstr;

World box_world() {
  World world;
  world.add_box({5, 0, 1}, {2, 4, 2}, 0.0, Material::black);
  return world;
}

TEST(RayCaster, HitsTheNearFaceWithItsNormalAndMaterial) {
  const World world = box_world();
  const RayCaster rays(world);
  const auto hit = rays.cast({0, 0, 1}, {1, 0, 0}, 100.0F);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 4.0F, 1e-5);
  EXPECT_NEAR(hit->normal.x(), -1.0F, 1e-5);
  EXPECT_EQ(hit->material, Material::black);
  EXPECT_FALSE(rays.cast({0, 0, 1}, {1, 0, 0}, 3.9F));
  EXPECT_FALSE(rays.cast({0, 0, 1}, {-1, 0, 0}, 100.0F));
}

TEST(RayCaster, DistancesEqualThoseOfTheSlowWay) {
  World world;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-3, 3);
  for (int i = 0; i < 20; ++i) {
    world.add_box({uniform(random), uniform(random), uniform(random)}, {0.5, 0.8, 0.3},
                  uniform(random), Material::plain);
  }
  const RayCaster rays(world);
  // The slow way: the nearest of many points strewn on every triangle. It can only be too long, by
  // no more than half the points' distance.
  constexpr int kSteps = 24;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3f point(static_cast<float>(uniform(random)),
                                static_cast<float>(uniform(random)),
                                static_cast<float>(uniform(random)));
    float slow = 1e9F;
    for (const auto& triangle : world.triangles) {
      const Eigen::Vector3f a = world.vertices_m[triangle[0]], b = world.vertices_m[triangle[1]],
                            c = world.vertices_m[triangle[2]];
      for (int u = 0; u <= kSteps; ++u) {
        for (int v = 0; u + v <= kSteps; ++v) {
          const Eigen::Vector3f on = a + (b - a) * (static_cast<float>(u) / kSteps) +
                                     (c - a) * (static_cast<float>(v) / kSteps);
          slow = std::min(slow, (on - point).norm());
        }
      }
    }
    const float fast = rays.distance_to_surface_m(point, 100.0F);
    EXPECT_LE(fast, slow + 1e-5F);
    EXPECT_NEAR(fast, slow, 0.03F);
  }
}

TEST(World, ADoorStandsOpenAsFarAsItsFileSays) {
  WorldSpec spec;
  spec.doors.resize(1);
  spec.doors[0].hinge_m = {5, 5};
  spec.doors[0].open_deg = 90.0;
  const World world = build_world(spec);
  const RayCaster rays(world);
  // Closed it would lie along +x; open it lies along +y.
  EXPECT_LT(rays.distance_to_surface_m({5, 5.5F, 1}, 1.0F), 0.05F);
  EXPECT_GT(rays.distance_to_surface_m({5.5F, 5, 1}, 1.0F), 0.3F);
}

// Rays to the axis of a cylinder: within the 0.2 mm that its flat sides may be off.
TEST(World, ColumnsAndBentWallsAreRound) {
  WorldSpec spec;
  spec.floor_m = {-9, -9, 9, 9};
  spec.columns.resize(1);
  spec.columns[0] = {{0, 0}, 0.075, 1.0};
  spec.arcs.resize(1);
  spec.arcs[0].radius_m = 5.0;
  spec.arcs[0].from_deg = -90;
  spec.arcs[0].to_deg = 180;
  const World world = build_world(spec);
  EXPECT_EQ(world.triangles.size(), world.materials.size());
  const RayCaster rays(world);
  for (int degree = -89; degree < 180; ++degree) {
    const Eigen::Vector2d ray(std::cos(deg_to_rad(degree)), std::sin(deg_to_rad(degree)));
    const Eigen::Vector3f out(static_cast<float>(ray.x()), static_cast<float>(ray.y()), 0.0F);
    const Eigen::Vector3f knee(0, 0, 0.5F);
    const auto column = rays.cast(2.0F * out + knee, -out, 9.0F);
    const auto inside = rays.cast(out + knee, out, 9.0F);
    const auto outside = rays.cast(8.0F * out + knee, -out, 9.0F);
    ASSERT_TRUE(column && inside && outside);
    EXPECT_NEAR(column->range_m, 2.0 - 0.075, 2.1e-4) << degree;
    EXPECT_NEAR(inside->range_m, 3.94, 2.1e-4) << degree;
    EXPECT_NEAR(outside->range_m, 2.94, 2.1e-4) << degree;
  }
  // It ends where its file says, and the column has a top.
  EXPECT_FALSE(rays.cast({0, 0, 1.5F}, {-0.7071F, -0.7071F, 0}, 8.0F));
  EXPECT_NEAR(rays.distance_to_surface_m({-5, 0.02F, 1}, 1.0F), 0.0, 0.07);
  EXPECT_NEAR(rays.cast({0.02F, 0.01F, 2}, {0, 0, -1}, 9.0F)->range_m, 1.0, 1e-4);
}

TEST(World, MistakesInAFileAreNamed) {
  WorldSpec spec;
  spec.walls.resize(1);
  spec.walls[0].corners_m = {1, 2, 3};
  EXPECT_NE(complaint([&] { build_world(spec); }), "");
  spec.walls[0].corners_m = {1, 2, 3, 4};
  spec.walls[0].material = "velvet";
  EXPECT_THAT(complaint([&] { build_world(spec); }), HasSubstr("velvet"));
  spec.walls.clear();
  spec.arcs.resize(1);
  spec.arcs[0].to_deg = -10.0;
  EXPECT_THAT(complaint([&] { build_world(spec); }), HasSubstr("arcs.to_deg"));
  spec.arcs[0].to_deg = 10.0;
  spec.arcs[0].thickness_m = 7.0;
  EXPECT_THAT(complaint([&] { build_world(spec); }), HasSubstr("arcs.thickness_m"));
}

TEST(World, EveryShippedWorldAndTourLoads) {
  for (const char* name : {"lab", "office", "flat", "foyer", "rotunda"}) {
    const World world = build_world(
        process::load_options<WorldSpec>("config/worlds/" + std::string(name) + ".toml"));
    EXPECT_GT(world.triangles.size(), 100U);
    EXPECT_EQ(world.triangles.size(), world.materials.size());
    const auto tour = process::load_options<Tour>("config/tours/" + std::string(name) + ".toml");
    const MotionPlan plan(tour, RobotOptions{}, 37.5);
    EXPECT_GT(plan.duration_s(), 60.0);
    // Nowhere on its way may the robot stand in a wall.
    const RayCaster rays(world);
    for (double t = 0; t < plan.duration_s(); t += 0.5) {
      const Eigen::Vector2d at = plan.at(t).world_from_robot.translation_m();
      EXPECT_GT(rays.distance_to_surface_m(
                    {static_cast<float>(at.x()), static_cast<float>(at.y()), 0.3F}, 1.0F),
                0.2F)
          << name << " at " << t << " s";
    }
  }
  EXPECT_EQ(build_world(process::load_options<WorldSpec>("config/worlds/foyer.toml")).people.size(),
            6U);
}

}  // namespace
}  // namespace marco::sim
