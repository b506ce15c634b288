#pragma once

#include <cstdint>
#include <string>

namespace marco::logs {

/// "marco.pose2_t" of a fingerprint, "" when it is none of those known.
std::string type_name(uint64_t fingerprint);

}  // namespace marco::logs
