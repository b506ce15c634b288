#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/trajectory.hpp"

namespace marco {

/// A hand-checked relative pose of a benchmark: `second` seen from `first`.
struct PoseRelation {
  double first_time_s = 0.0;
  double second_time_s = 0.0;
  Pose2 first_from_second;
};

struct ErrorSpread {
  double mean = 0.0;
  double std = 0.0;  ///< of the population
  double p95 = 0.0;
  double max = 0.0;
};

struct RelationsError {
  std::size_t count = 0;
  ErrorSpread translation_m;
  ErrorSpread rotation_deg;
};

/// Errors of a trajectory against relations (Kuemmerle et al., Autonomous Robots 2009, with the
/// errors' absolute values): all of them, and those whose times lie more than 60 s apart.
struct RelationsReport {
  RelationsError all;
  RelationsError far_apart;
  std::size_t skipped = 0;  ///< no pose within the tolerance of one of its times
};

RelationsReport compare_with_relations(const Trajectory& trajectory,
                                       const std::vector<PoseRelation>& relations,
                                       double tolerance_s = 2e-6);

}  // namespace marco
