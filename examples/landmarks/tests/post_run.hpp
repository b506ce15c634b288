#pragma once

#include <Eigen/LU>
#include <chrono>
#include <cstddef>

#include "common/trajectory_fit.hpp"
#include "landmarks/landmark_slam.hpp"
#include "tests/post_drive.hpp"

namespace marco::testing {

/// What LandmarkSlam made of a simulated drive.
struct PostResult {
  double path_rms_m = 0.0;            ///< causal path, after its best rigid fit to the truth
  double dead_reckoning_rms_m = 0.0;  ///< the same of the wheels alone
  int found = 0;                      ///< posts with a landmark within 4 cm, after that fit
  int landmarks = 0;
  double worst_post_m = 0.0;  ///< distance of a post to the nearest landmark
  double mean_nees = 0.0;     ///< of the pose; 3 is honest
  double ms_per_scan = 0.0;
  slam::SightingNoise noise;
  double noise_factor = 1.0;
};

inline Trajectory dead_reckoning(const PostDrive& drive) {
  Trajectory path;
  slam::WheelIntegral wheels;
  for (const slam::WheelVelocity& sample : drive.wheels) {
    wheels.add(sample, slam::SetUpVector::Zero(), {});
    path.push_back({sample.utime, wheels.motion().start_from_end});
  }
  return path;
}

inline PostResult run_posts(const PostDrive& drive, const slam::LandmarkSlamOptions& options) {
  slam::LandmarkSlam slam(options);
  PostResult result;
  Trajectory path;
  std::size_t next_scan = 0, truths = 0;
  double nees = 0.0;
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    slam.process(drive.wheels[i]);
    if (next_scan < drive.scans.size() && drive.scans[next_scan].utime == drive.wheels[i].utime) {
      slam.process(drive.scans[next_scan++]);
      if (slam.filter().size() > 0) {
        Eigen::Vector3d error =
            slam.world_from_robot().vector() - drive.truth[i].world_from_robot.vector();
        error.z() = normalize_angle(error.z());
        nees += error.dot(slam.robot_covariance().inverse() * error);
        ++truths;
      }
    }
    path.push_back({drive.wheels[i].utime, slam.world_from_robot()});
  }
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  result.ms_per_scan = took.count() / static_cast<double>(drive.scans.size());
  const TrajectoryFit fit = fit_to_truth(path, drive.truth);
  result.path_rms_m = fit.rms_m;
  result.dead_reckoning_rms_m = fit_to_truth(dead_reckoning(drive), drive.truth).rms_m;
  result.mean_nees = nees / static_cast<double>(truths);
  result.noise = slam.noise();
  result.noise_factor = slam.noise_factor();
  const auto landmarks = slam.landmarks();
  result.landmarks = static_cast<int>(landmarks.size());
  for (const Eigen::Vector2d& post : drive.posts) {
    double nearest_m = 1e9;
    for (const slam::MapLandmark& landmark : landmarks) {
      nearest_m =
          std::min(nearest_m, (fit.truth_from_estimate * landmark.in_world_m - post).norm());
    }
    result.worst_post_m = std::max(result.worst_post_m, nearest_m);
    result.found += nearest_m < 0.04 ? 1 : 0;
  }
  return result;
}

}  // namespace marco::testing
