#pragma once

#include <string>

namespace marco::logs {

/// The JSON schema of one of Foxglove's messages, as FoxgloveTranslator writes them.
/// @param name  "foxglove.LaserScan" ...; others get a schema of a time stamp and a frame
std::string foxglove_schema(const std::string& name);

}  // namespace marco::logs
