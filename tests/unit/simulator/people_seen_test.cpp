// What lasers see of people, in the batch simulation and live.
#include <gtest/gtest.h>

#include <cmath>

#include "lcmtypes/channels.hpp"
#include "simulator/batch_simulation.hpp"
#include "simulator/live/live_laser.hpp"

namespace marco::sim {
namespace {

// A room of 8 m x 6 m about the origin, where two people walk.
WorldSpec room_with_people() {
  WorldSpec spec;
  spec.floor_m = {-4, -3, 4, 3};
  spec.walls.resize(1);
  spec.walls[0].corners_m = {-4, -3, 4, -3, 4, 3, -4, 3, -4, -3};
  spec.people.resize(2);
  spec.people[0].waypoints_m = {2, -2, 2, 2};
  spec.people[1].waypoints_m = {-2, -2, 1.5, -2, -2, 1, -2, -2};
  spec.people[1].speed_m_per_s = 0.8;
  spec.people[1].ahead_s = 1.0;
  return spec;
}

// A slow laser without noise: people walk a step within a scan.
LaserOptions slow_laser() {
  LaserOptions laser;
  laser.scans_per_s = 1.0;
  laser.interlaced_turns = 1;
  laser.scan_duration_s = 0.9;
  laser.range_sigma_m = laser.missing_part = laser.footprint_deg = laser.quantum_m = 0.0;
  laser.first_bearing_deg = -180.0;
  laser.step_deg = 1.0;
  laser.beams = 360;
  return laser;
}

// The nearest of walls and legs at a time.
double range_seen_m(const RayCaster& walls,
                    const World& world,
                    const Pose3& world_from_laser,
                    double bearing_rad,
                    double seconds) {
  const Eigen::Vector3d origin = world_from_laser.translation();
  const Eigen::Vector3d direction =
      world_from_laser.linear() *
      Eigen::Vector3d(std::cos(bearing_rad), std::sin(bearing_rad), 0.0);
  const auto hit = walls.cast(origin.cast<float>(), direction.cast<float>(), 30.0F);
  double nearest_m = hit ? static_cast<double>(hit->range_m) : 100.0;
  for (const Person& person : world.people) {
    for (const Leg& leg : person.legs_at(seconds)) {
      nearest_m = std::min(nearest_m, range_to_leg(leg, origin, direction).value_or(100.0));
    }
  }
  return nearest_m;
}

struct Seen {
  int beams = 0, of_people = 0, elsewhere_at_first_beam = 0;
  double worst_m = 0.0;
};

// @param seconds  of a beam, by the world's clock
void compare(const std::vector<float>& ranges_m,
             const Pose3& pose,
             const std::function<double(int)>& seconds,
             Seen& seen) {
  const World world = build_world(room_with_people());
  WorldSpec spec = room_with_people();
  spec.people.clear();
  const World empty = build_world(spec);
  const RayCaster walls(empty);
  const LaserOptions laser = slow_laser();
  for (int beam = 0; beam < laser.beams; ++beam) {
    const double bearing_rad = deg_to_rad(laser.first_bearing_deg + beam * laser.step_deg);
    const double truth_m = range_seen_m(walls, world, pose, bearing_rad, seconds(beam));
    const double first_m = range_seen_m(walls, world, pose, bearing_rad, seconds(0));
    const double wall_m = range_seen_m(walls, empty, pose, bearing_rad, 0.0);
    const double off_m = std::abs(static_cast<double>(ranges_m.at(beam)) - truth_m);
    ++seen.beams;
    seen.worst_m = std::max(seen.worst_m, off_m);
    if (truth_m < wall_m - 0.2) ++seen.of_people;
    if (std::abs(truth_m - first_m) > 0.02) ++seen.elsewhere_at_first_beam;
  }
}

void expect_people_at_each_beam(const Seen& seen) {
  EXPECT_LT(seen.worst_m, 1e-4);  // rays are single-precision, and may graze
  EXPECT_GT(seen.of_people, 50);
  EXPECT_GT(seen.elsewhere_at_first_beam, 20);
}

TEST(People, AreSeenWhereTheyAreAtTheTimeOfEachBeam) {
  const World world = build_world(room_with_people());
  const RayCaster rays(world);
  SimulationOptions options;
  options.laser = slow_laser();
  options.odometry.floor_tilt_deg = 0.0;
  Tour standing;
  standing.steps.resize(1);
  standing.steps[0].kind = "wait";
  standing.steps[0].seconds = 12.0;
  for (const char* times : {"right", "reversed"}) {
    options.logger.beam_times = times;
    BatchSimulation simulation(rays, standing, options, 1);
    Seen seen;
    simulation.run([&](const Sample& sample, Utime) {
      const auto* scan = std::get_if<LaserScan>(&sample);
      if (scan == nullptr || scan->channel != channels::kLidarRaw) return;
      const double began_s = (scan->utime - BatchSimulation::kStart).seconds();
      compare(
          scan->ranges_m, simulation.world_from_laser(0.0),
          [&](int beam) {
            const double said_s = options.laser.time_of_beam_s(beam);
            return began_s + (times == std::string("right") ? said_s : 0.9 - said_s);
          },
          seen);
    });
    EXPECT_GT(seen.beams, 3000);
    expect_people_at_each_beam(seen);
  }
}

TEST(People, AreSeenByALiveLaserByTheClock) {
  const World world = build_world(room_with_people());
  const RayCaster rays(world);
  LiveLaserSpec spec;
  spec.optics = slow_laser();
  const Pose3 pose = make_pose3({0.3, 0.2, 0.4});
  const FaultBoard no_faults;
  LiveLaser laser(
      rays, spec, [&pose](Utime) { return pose; }, no_faults, 1);
  Seen seen;
  for (int i = 0; i < 10; ++i) {
    drivers::LaserSweep sweep;
    sweep.first_beam = Utime::from_us(1'700'000'000'000'000 + i * 1'000'000);
    sweep.beam_interval_s = 0.9 / 359;
    sweep.first_bearing_rad = deg_to_rad(-180.0);
    sweep.bearing_step_rad = deg_to_rad(1.0);
    sweep.beams = 360;
    const std::vector<double> answer = laser.sweep(sweep);
    compare(
        std::vector<float>(answer.begin(), answer.end()), pose,
        [&](int beam) { return sweep.first_beam.seconds() + beam * sweep.beam_interval_s; }, seen);
  }
  expect_people_at_each_beam(seen);
}

TEST(People, OutOfSightChangeNoScanAndStandInNoTruth) {
  WorldSpec spec = room_with_people();
  spec.people.clear();
  const World empty = build_world(spec);
  spec.people.resize(1);
  spec.people[0].waypoints_m = {20, 20, 25, 20};
  const World with_someone = build_world(spec);
  EXPECT_EQ(with_someone.vertices_m, empty.vertices_m);
  EXPECT_EQ(with_someone.triangles, empty.triangles);
  const RayCaster rays(empty), rays_too(with_someone);
  Tour tour;
  tour.steps.resize(1);
  tour.steps[0].to_m = {1, 0};
  std::vector<std::vector<float>> ranges_m[2];
  for (const RayCaster* world : {&rays, &rays_too}) {
    BatchSimulation(*world, tour, harsh_options(), 3).run([&](const Sample& sample, Utime) {
      const auto* scan = std::get_if<LaserScan>(&sample);
      if (scan != nullptr) ranges_m[world == &rays ? 0 : 1].push_back(scan->ranges_m);
    });
  }
  EXPECT_GT(ranges_m[0].size(), 10U);
  EXPECT_EQ(ranges_m[0], ranges_m[1]);
}

TEST(People, AreNoWallsForWhoAsksForWalls) {
  const World world = build_world(room_with_people());
  const RayCaster rays(world);
  const Leg leg = world.people[0].legs_at(0.0)[0];
  const Eigen::Vector3f at(static_cast<float>(leg.centre_m.x()),
                           static_cast<float>(leg.centre_m.y()), 0.4F);
  EXPECT_GT(rays.distance_to_surface_m(at, 5.0F), 0.3F);
  const auto hit = rays.cast(at - Eigen::Vector3f(1, 0, 0), {1, 0, 0}, 30.0F);
  ASSERT_TRUE(hit.has_value());
  EXPECT_GT(hit->range_m, 2.0F);
}

}  // namespace
}  // namespace marco::sim
