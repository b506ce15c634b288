// The joined surface of the simulated lab against its true surfaces: three stops, four pans each,
// default noise, the laser's true poses (how well scenes are registered is another test's matter).
#include <gtest/gtest.h>

#include <cstdio>
#include <ctime>

#include "lcm_tools/process/config.hpp"
#include "mapping3d/scene_mesh.hpp"
#include "mapping3d/surface/simplify.hpp"
#include "mapping3d/surface/surface_model.hpp"
#include "simulator/batch_simulation.hpp"
#include "tools/evaluate/model_judge.hpp"

namespace marco {
namespace {

struct Recorded {
  std::vector<mapping3d::ScenePoints> scenes;
  std::vector<BeamEnd> ends;
};

Recorded record(const sim::RayCaster& world) {
  const sim::SimulationOptions options;
  sim::BatchSimulation simulation(world, process::load_options<sim::Tour>("config/tours/lab.toml"),
                                  options, 7);
  mapping3d::SceneBuilder builder;
  Recorded recorded;
  PanTiltState state;
  const auto keep = [&](const std::optional<mapping3d::Scene>& scene) {
    if (scene) recorded.scenes.push_back(mapping3d::place(*scene));
  };
  simulation.run([&](const Sample& sample, Utime) {
    if (const auto* now = std::get_if<PanTiltState>(&sample)) state = *now;
    const auto* scan = std::get_if<LaserScan>(&sample);
    if (scan == nullptr || !scan->time_offsets_s.empty()) return;  // each comes twice
    const double first_s = (scan->utime - sim::BatchSimulation::kStart).seconds();
    mapping3d::SceneRow row;
    row.utime = scan->utime;
    row.first_bearing_rad = scan->first_bearing_rad;
    row.bearing_step_rad = scan->bearing_step_rad;
    row.robot_from_sensor_first = simulation.world_from_laser(first_s);
    row.robot_from_sensor_last =
        simulation.world_from_laser(first_s + options.laser.scan_duration_s);
    for (const float range : scan->ranges_m) {
      row.ranges_m.push_back(range < 32.0F ? range : 0.0F);
    }
    keep(builder.add(row, state.pan_rad, state.tilt_rad));
  });
  keep(builder.finish());
  for (const mapping3d::ScenePoints& scene : recorded.scenes) {
    for (std::size_t i = 0; i < scene.points_m.size(); i += 3) {
      if (scene.valid[i] == 0) continue;
      const Eigen::Vector3f& origin = scene.origins_m[i / scene.columns];
      const Eigen::Vector3f way = (scene.points_m[i] - origin).normalized();
      const auto hit = world.cast(origin, way, 32.0F);
      if (hit) recorded.ends.push_back({origin + hit->range_m * way, hit->normal, hit->triangle});
    }
  }
  return recorded;
}

TEST(LabSurface, LiesOnTheTrueSurfaces) {
  const sim::RayCaster world(
      sim::build_world(process::load_options<sim::WorldSpec>("config/worlds/lab.toml")));
  const Recorded recorded = record(world);
  ASSERT_GE(recorded.scenes.size(), 12U);
  const std::clock_t begin = std::clock();
  const TriangleMesh mesh = mapping3d::fuse(recorded.scenes);
  std::printf("%zu scenes fused in %.2f s of CPU\n", recorded.scenes.size(),
              static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  const ModelJudgement found = judge_model(mesh, world, recorded.ends);
  std::printf("surface: rms %.4f p99 %.4f max %.4f m, covered %.4f, sheets > 20 mm at %zu of %zu\n",
              found.error.rms_m, found.error.p99_m, found.error.max_m, found.coverage->covered,
              found.sheets->too_far, found.sheets->places);
  EXPECT_LT(found.error.rms_m, 0.005);
  EXPECT_LT(found.error.p99_m, 0.020);
  EXPECT_GT(found.coverage->covered, 0.975);
  EXPECT_LT(static_cast<double>(found.sheets->too_far),
            2e-4 * static_cast<double>(found.sheets->places));
  // Thesis B's way beside it.
  TriangleMesh scenes;
  for (const mapping3d::ScenePoints& scene : recorded.scenes) {
    mapping3d::append_mesh(scenes, mapping3d::mesh_scene(scene));
  }
  const Spread thesis = judge_model(scenes, world, {}).error;
  std::printf("scenes one over another: rms %.4f p99 %.4f m\n", thesis.rms_m, thesis.p99_m);
  EXPECT_GT(thesis.rms_m, 2.0 * found.error.rms_m);
  const mapping3d::Simplified fewer = mapping3d::simplify(mesh, mapping3d::find_planes(mesh));
  const double share =
      static_cast<double>(fewer.mesh.triangles.size()) / static_cast<double>(mesh.triangles.size());
  std::printf("simplified: %.4f of %zu triangles, %.4f m there, %.4f m back\n", share,
              mesh.triangles.size(), fewer.there_m, fewer.back_m);
  EXPECT_LT(share, 0.05);
  EXPECT_LE(std::max(fewer.there_m, fewer.back_m), 0.01);
}

}  // namespace
}  // namespace marco
