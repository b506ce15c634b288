#pragma once

#include <vector>

#include "lcm_tools/schema/schema.hpp"

namespace marco::lcm_schema {

/// Parses one source into declarations (types of members not yet looked up). At the first mistake
/// of a declaration it records a problem and continues after that declaration.
std::vector<Structure> parse_source(const Source& source, std::vector<Problem>& problems);

}  // namespace marco::lcm_schema
