#pragma once

#include <random>

#include "common/covariance.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::testing {

/// What a robot sees at `pose`, whose believed pose is off by `drift`, of a place seen from the
/// origin.
inline slam::LoopCandidate candidate_of(const FlatWorld& place,
                                        const FlatWorld& seen,
                                        const Pose2& pose,
                                        const Pose2& drift,
                                        double sigma_m = 1.0) {
  std::mt19937 random(4);
  slam::LoopCandidate candidate;
  candidate.from = 3;
  candidate.to = 40;
  candidate.world_from_newest = pose * drift;
  candidate.place = slam::orient(place.hits({}, 0.01, &random), {0, 0}, {});
  candidate.seen = slam::orient(seen.hits(pose, 0.01, &random), {0, 0}, {});
  candidate.covariance = diagonal_covariance(sigma_m, 0.067);
  return candidate;
}

}  // namespace marco::testing
