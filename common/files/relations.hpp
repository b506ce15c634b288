#pragma once

#include <string>
#include <vector>

#include "common/relations_metric.hpp"

namespace marco::files {

/// The relations of a public benchmark log, one per line: `time1 time2 x y z roll pitch yaw`
/// (seconds, metres, radians), the second pose seen from the first.
/// @throws as read_numeric_rows(), and where a line holds fewer numbers.
std::vector<PoseRelation> read_relations(const std::string& path);

}  // namespace marco::files
