#pragma once

#include <string>

namespace marco::foxglove {

/// The JSON schema of one of Foxglove's messages, as FoxgloveTranslator writes them.
/// @param name  "foxglove.LaserScan" ...; others get a schema of a time stamp and a frame
std::string schema_of(const std::string& name);

}  // namespace marco::foxglove
