#pragma once

#include <vector>

#include "common/input/own_body.hpp"
#include "recordings/recording.hpp"

namespace marco {

/// Reads a recording's scans until they have told whether its lasers see the robot that bears them
/// (OwnBody), or to its end. A laser on a pan-tilt is left alone.
/// @param known  what is known of it already
/// @returns the parts that were found besides
std::vector<BodyPart> find_own_body(const RecordingParts& parts,
                                    const ForeignTable& foreign,
                                    const std::vector<BodyPart>& known);

}  // namespace marco
