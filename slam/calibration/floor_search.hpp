#pragma once

#include <optional>
#include <vector>

#include "common/input/floor_line.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// Finds the line along which a laser that is not level sees the floor or the ceiling: in the
/// laser's frame many returns lie on one straight line, nothing is beyond it, and the line turns
/// with the robot: near keyframes with another heading see through it, as through no wall. Poses
/// are those of the keyframes, so that a map may be bent, but not scrambled. A pure function.
/// @param keys  all of one laser, which is fixed to the robot, in the order of their times
/// @returns nothing where there is none, or the drive has too few turns to tell it from a wall
/// that is followed. The channel is empty.
std::optional<FloorLine> find_floor(const std::vector<Keyframe>& keys);

}  // namespace marco::slam
