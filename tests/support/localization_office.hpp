#pragma once

#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "common/trajectory_fit.hpp"
#include "lcm_tools/process/config.hpp"
#include "simulator/batch_simulation.hpp"
#include "tests/support/localization_trials.hpp"

namespace marco::testing {

/// The simulated office, mapped on a tour, and robots that are switched on anywhere in it.
class Office {
 public:
  static constexpr double kLaserAheadM = 0.145;
  static constexpr double kLaserHeightM = 0.608;

  Office()
      : rays_(sim::build_world(process::load_options<sim::WorldSpec>("config/worlds/office.toml"))),
        laser_(rays_, options()) {}

  // The tour, mapped; the map's frame is the tour's first pose.
  std::vector<slam::Keyframe> map(double scans_per_s = 4.0) {
    sim::SimulationOptions simulation;
    simulation.laser = options();
    simulation.laser.scans_per_s = scans_per_s;
    sim::Tour tour = process::load_options<sim::Tour>("config/tours/office.toml");
    world_from_map_ = {tour.start_m[0], tour.start_m[1], deg_to_rad(tour.start_heading_deg)};
    slam::Slam mapper;
    Pose2 odom_from_robot;
    Trajectory truth;
    sim::BatchSimulation(rays_, tour, simulation, 7).run([&](const Sample& sample, Utime) {
      if (const auto* pose = std::get_if<TruePose>(&sample)) {
        truth.push_back({pose->utime, pose->world_from_robot});
      }
      if (const auto* odometry = std::get_if<OdometrySample>(&sample)) {
        odom_from_robot = odometry->odom_from_robot;
      }
      const auto* scan = std::get_if<LaserScan>(&sample);
      if (scan != nullptr && scan->time_offsets_s.empty()) {  // each comes twice
        mapper.process(input_of(*scan, odom_from_robot, mapper.velocity_during({}, 0.0).velocity));
      }
    });
    mapper.finish();
    world_from_map_ = fit_to_truth(mapper.trajectory(), truth).truth_from_estimate;
    return mapper.keys();
  }

  const Pose2& world_from_map() const { return world_from_map_; }

  // Somewhere free, then ahead while there is room, else a turn: `path_m` in all.
  std::vector<TrialStep> drive(uint64_t seed, double path_m) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::normal_distribution<double> normal(0.0, 1.0);
    Pose2 robot;
    do {
      robot = {32.0 * uniform(random), 20.0 * uniform(random),
               2.0 * std::numbers::pi * (uniform(random) - 0.5)};
    } while (!has_room(robot) || !inside(robot));
    std::vector<TrialStep> steps;
    Pose2 odom_from_robot{5.0, -3.0, 1.0};
    double driven_m = 0.0;
    int64_t us = static_cast<int64_t>(seed) * 1'000'000'000;
    const double side = uniform(random) < 0.5 ? -1.0 : 1.0;
    for (int i = 0; i < 400 && driven_m <= path_m; ++i, us += 200000) {
      LaserScan scan;
      scan.utime = Utime::from_us(us);
      const Pose3 world_from_laser = lift(robot) * make_pose3({kLaserAheadM, 0.0, kLaserHeightM});
      scan.ranges_m =
          laser_.scan([&](double) { return sim::LaserMoment{world_from_laser}; }, random);
      scan.first_bearing_rad = deg_to_rad(-90.0);
      scan.bearing_step_rad = deg_to_rad(0.5);
      steps.push_back({input_of(scan, odom_from_robot, {}), world_from_map_.inverse() * robot});
      const Pose2 ahead = robot * Pose2{0.1, 0, 0.02 * normal(random)};
      const bool go = has_room(robot * Pose2{0.35, 0, 0});
      const Pose2 step = go ? between(robot, ahead) : Pose2{0, 0, side * deg_to_rad(10)};
      robot = robot * step;
      if (go) driven_m += 0.1;
      odom_from_robot =
          odom_from_robot * Pose2{1.05 * step.x_m, step.y_m, 1.03 * step.theta_rad + 0.001};
    }
    return steps;
  }

 private:
  static sim::LaserOptions options() {
    sim::LaserOptions options;
    options.scan_duration_s = 0.0;
    return options;
  }
  static slam::SlamInput input_of(const LaserScan& scan,
                                  const Pose2& odom,
                                  const Velocity2& velocity) {
    SensorInfo info;
    info.range_min_m = 0.05;
    info.range_max_m = static_cast<double>(static_cast<float>(options().range_max_m));
    slam::SlamInput input;
    input.scan =
        deskew_and_project(scan, info, make_pose3({kLaserAheadM, 0.0, kLaserHeightM}), velocity);
    input.motion = {scan.utime, odom, {}};
    return input;
  }
  bool has_room(const Pose2& robot) const {
    for (const float height_m : {0.4F, 0.75F}) {
      const Eigen::Vector3f at(static_cast<float>(robot.x_m), static_cast<float>(robot.y_m),
                               height_m);
      if (rays_.distance_to_surface_m(at, 0.5F) < 0.35F) return false;
    }
    return true;
  }
  // Not in the shafts between the walls, where no robot comes.
  bool inside(const Pose2& robot) const {
    const bool in_core = robot.x_m > 2.2 && robot.x_m < 29.8 && robot.y_m > 8 && robot.y_m < 12;
    return !in_core;
  }

  sim::RayCaster rays_;
  sim::LaserModel laser_;
  Pose2 world_from_map_;
};

}  // namespace marco::testing
