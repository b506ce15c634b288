#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "common/trajectory.hpp"
#include "landmarks/sighting.hpp"

namespace marco::testing {

/// A drive among posts, simulated.
struct PostWorld {
  int posts = 17;
  double width_m = 12.0, height_m = 9.0;
  double least_gap_m = 1.0;  ///< between posts
  int pairs = 0;             ///< this many posts have a neighbour at `pair_gap_m`
  double pair_gap_m = 0.4;
  double way_m = 340.0;
  double speed_m_per_s = 0.27;
  double rate_hz = 10.0;
  int scan_every = 1;  ///< samples
  double reach_m = 5.0;
  double view_rad = 2.0 * std::numbers::pi;  ///< the sensor's, ahead in the middle
  double range_sigma_m = 0.033;
  double bearing_sigma_rad = 0.026;
  double speed_sigma_m_per_s = 0.02;  ///< white, per sample
  double turn_sigma_rad_per_s = 0.06;
  double speed_scale = 1.0, turn_scale = 1.0, turn_bias_rad_per_s = 0.0;  ///< measured of true
  double sensor_ahead_m = 0.0, sensor_left_m = 0.0, sensor_yaw_rad = 0.0;
  double missed_part = 0.0;
  double clutter_part = 0.0;                    ///< false sightings, of the true ones
  double blind_from_s = 0.0, blind_to_s = 0.0;  ///< no scans
};

struct PostDrive {
  std::vector<Eigen::Vector2d> posts;
  std::vector<slam::WheelVelocity> wheels;
  std::vector<slam::SightingScan> scans;
  Trajectory truth;  ///< in the frame of its first pose, which posts are in as well
};

class PostSimulation {
 public:
  PostSimulation(const PostWorld& world, unsigned seed) : world_(world), random_(seed) {}

  PostDrive run() {
    plant();
    const double dt = 1.0 / world_.rate_hz;
    Pose2 robot{0.5 * world_.width_m, 0.5 * world_.height_m, uniform(-3.0, 3.0)};
    const Pose2 first_from_room = robot.inverse();
    Eigen::Vector2d goal = somewhere();
    double speed = 0.0, turn = 0.0, way_m = 0.0;
    double counted_m = 0.0, counted_rad = 0.0;  // by the wheels since the sample before
    for (int step = 0; way_m < world_.way_m; ++step) {
      const double now_s = step * dt;
      const Utime utime = Utime::from_seconds(1000.0 + now_s);
      drive_.truth.push_back({utime, first_from_room * robot});
      drive_.wheels.push_back(
          {utime, counted_m / dt * world_.speed_scale + normal(world_.speed_sigma_m_per_s),
           counted_rad / dt * world_.turn_scale + world_.turn_bias_rad_per_s +
               normal(world_.turn_sigma_rad_per_s)});
      const bool blind = now_s >= world_.blind_from_s && now_s < world_.blind_to_s;
      if (step % world_.scan_every == 0 && !blind) look(utime, robot);
      if ((goal - robot.translation_m()).norm() < 0.5) goal = somewhere();
      const Eigen::Vector2d to_goal = goal - robot.translation_m();
      const double off = normalize_angle(std::atan2(to_goal.y(), to_goal.x()) - robot.theta_rad);
      const double wanted = std::clamp(1.0 * off, -0.6, 0.6);
      const double before_speed = speed, before_turn = turn;
      turn += std::clamp(wanted - turn, -1.0 * dt, 1.0 * dt);
      const double wanted_speed = world_.speed_m_per_s * (std::abs(off) > 1.0 ? 0.2 : 1.2);
      speed += std::clamp(wanted_speed - speed, -0.3 * dt, 0.3 * dt);
      const double d = 0.5 * (speed + before_speed) * dt, a = 0.5 * (turn + before_turn) * dt;
      robot = robot * Pose2{d * std::cos(0.5 * a), d * std::sin(0.5 * a), a};
      way_m += d;
      counted_m = d;
      counted_rad = a;
    }
    for (Eigen::Vector2d& post : drive_.posts) post = first_from_room * post;
    return drive_;
  }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double normal(double sigma) { return sigma * std::normal_distribution<double>()(random_); }
  Eigen::Vector2d somewhere() {
    return {uniform(0.5, world_.width_m - 0.5), uniform(0.5, world_.height_m - 0.5)};
  }

  void plant() {
    while (static_cast<int>(drive_.posts.size()) < world_.posts) {
      const Eigen::Vector2d post = somewhere();
      const bool apart = std::all_of(
          drive_.posts.begin(), drive_.posts.end(),
          [&](const Eigen::Vector2d& other) { return (post - other).norm() > world_.least_gap_m; });
      if (!apart) continue;
      const bool paired = static_cast<int>(drive_.posts.size()) < 2 * world_.pairs;
      drive_.posts.push_back(post);
      if (!paired) continue;
      const double angle = uniform(-3.1, 3.1);
      drive_.posts.push_back(post +
                             world_.pair_gap_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }

  void look(Utime utime, const Pose2& robot) {
    slam::SightingScan scan{utime, {}};
    const Pose2 sensor_from_world =
        (robot * Pose2{world_.sensor_ahead_m, world_.sensor_left_m, world_.sensor_yaw_rad})
            .inverse();
    for (const Eigen::Vector2d& post : drive_.posts) {
      const Eigen::Vector2d at = sensor_from_world * post;
      const double bearing = std::atan2(at.y(), at.x());
      if (at.norm() > world_.reach_m || std::abs(bearing) > 0.5 * world_.view_rad) continue;
      if (uniform(0.0, 1.0) < world_.clutter_part) {
        scan.sightings.push_back({uniform(0.3, world_.reach_m),
                                  uniform(-0.5 * world_.view_rad, 0.5 * world_.view_rad), 0.0});
      }
      if (uniform(0.0, 1.0) < world_.missed_part) continue;
      scan.sightings.push_back({at.norm() + normal(world_.range_sigma_m),
                                normalize_angle(bearing + normal(world_.bearing_sigma_rad)), 0.0});
    }
    std::shuffle(scan.sightings.begin(), scan.sightings.end(), random_);
    drive_.scans.push_back(scan);
  }

  PostWorld world_;
  std::mt19937 random_;
  PostDrive drive_;
};

}  // namespace marco::testing
