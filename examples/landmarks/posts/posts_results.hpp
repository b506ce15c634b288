#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/trajectory.hpp"
#include "landmarks/landmark_slam.hpp"
#include "posts/posts_input.hpp"

namespace marco {

/// What a drive among landmarks came to.
struct PostsRun {
  Trajectory path;  ///< each pose by what was known at its time
  Trajectory dead_reckoning;
  std::vector<slam::MapLandmark> landmarks;
  slam::SightingNoise noise;
  double noise_factor = 1.0;  ///< of sightings: see slam::SightingCorrelation
  slam::SetUpVector set_up, set_up_sigma;
  slam::BearingConvention bearings;
  slam::LandmarkUpdate sums;  ///< over all scans
  std::size_t scans = 0, sightings = 0, refused_samples = 0;
  double seconds = 0.0;  ///< of work
};

/// The path against the truth, after the best rigid fit.
struct PathErrors {
  std::size_t used = 0, known = 0;  ///< true positions
  double rms_m = 0.0, median_m = 0.0, most_m = 0.0;
  Pose2 truth_from_world;
};

/// @returns nothing without truth. GPS fixes that jump, or stand alone, are left out: the car
/// cannot have been there.
std::optional<PathErrors> path_errors(const Trajectory& path, const PostsInput& input);

/// Writes path.tum, landmarks.json, landmarks.svg and report.json into a folder.
void write_posts(const std::filesystem::path& folder, const PostsRun& run, const PostsInput& input);

}  // namespace marco
