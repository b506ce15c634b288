#pragma once

#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// Joins rows of a laser that shifts its beams by a part of their spacing from scan to scan (the
/// interlaced modes of SICK's LMS) to rows with all of the beams, so that neighbours of a beam in
/// the scene are neighbours in the room: without, a beam's neighbours in its row are four times as
/// far away as beams three rows on. A joined row takes from the first scan of a shift to the last
/// one; its `beam_parts` say how far the pan-tilt had turned at each beam. A scan that is missing
/// leaves its columns without return.
/// @returns the scene as it is where beams are not shifted by turns, the robot did not stand, or
/// the pan-tilt turned by more than beams are apart between two scans
Scene joined_rows(const Scene& scene);

}  // namespace marco::mapping3d
