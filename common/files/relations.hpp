#pragma once

#include <string>
#include <vector>

#include "common/relations_metric.hpp"

namespace marco::files {

/// The relations of a public benchmark log: a line each, `time1 time2 x y z roll pitch yaw`
/// (seconds, metres, radians), the second pose seen from the first. What follows a `#` and empty
/// lines are passed over.
/// @throws std::runtime_error when it cannot be read, std::invalid_argument with file and line when
/// a line holds fewer numbers, or something else than finite numbers.
std::vector<PoseRelation> read_relations(const std::string& path);

}  // namespace marco::files
