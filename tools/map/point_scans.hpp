#pragma once

#include <optional>

#include "tools/map/map_arguments.hpp"

namespace marco {

/// Gives points of 3D scanners, which are not recordings of a robot, to marco-model.
/// @returns its exit code; nothing when the inputs are not such points.
/// @throws std::invalid_argument for options that marco-model does not have.
std::optional<int> model_point_scans(const MapArguments& arguments);

}  // namespace marco
