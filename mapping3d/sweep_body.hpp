#pragma once

#include <vector>

#include "common/input/own_body.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// Finds what lasers on a pan-tilt, or fixed steeply, see of the robot that bears them: a frame, a
/// mast. Under one bearing the range stays the same to some centimetres, though the laser's motion
/// carries the beam's end from place to place; and other beams go through these places, so that
/// nothing stands there. A floor or a wall that is followed gives the same range, too, but stops
/// all beams. Near the axis of the pan-tilt a beam's end moves with the robot alone: it takes three
/// stops.
/// @returns parts of each laser, in the order of lasers and bearings
std::vector<BodyPart> find_own_body(const std::vector<Scene>& scenes);

/// Makes no returns of those that come from the parts.
void blank(Scene& scene, const std::vector<BodyPart>& parts);

}  // namespace marco::mapping3d
