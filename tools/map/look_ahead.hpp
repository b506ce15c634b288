#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/input/own_body.hpp"
#include "recordings/sample_reader.hpp"

namespace marco {

/// What has to be known of a recording before its first scan is mapped.
struct LookAhead {
  std::vector<BodyPart> body;  ///< of the robot, in view of its lasers (OwnBody)
  std::string odometry_fault;  ///< why its odometry cannot be used (OdometryUnits); "" = none found
};

/// Reads a recording until its scans have decided, or to its end. A laser on a pan-tilt is left
/// alone.
/// @param name  shown meanwhile
/// @param known  of the robot's body already; not among what is found
LookAhead look_ahead(files::SampleReader& recording,
                     const std::filesystem::path& name,
                     const std::vector<BodyPart>& known);

}  // namespace marco
