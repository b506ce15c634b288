#pragma once

#include <vector>

#include "lcm_tools/schema/schema.hpp"

namespace marco {

/// The texts of all `.lcm` files Marco was built with (bot_core's too), named
/// "built-in/PACKAGE/TYPE.lcm": tools know these types on machines without our sources.
std::vector<lcm_schema::Source> built_in_sources();

}  // namespace marco
