#pragma once

#include "common/gate.hpp"

namespace marco::mapping3d::sweep_gates {

// A robot and what it carries.
inline constexpr double kBodyWithinM = 2.5;
inline constexpr int kBodyRows = 20;
inline constexpr int kBodyPlaces = 3;
inline constexpr double kBodyPart = 0.8;
inline constexpr int kSeenThrough = 2;
inline constexpr double kSeenThroughPart = 0.6;

// clang-format off
/// Rules that decide what of a sweep is the robot's own.
inline constexpr Gate kSweepGates[] = {
    {"the robot in its own sweeps", "range [m], at most", kBodyWithinM, "its returns at this bearing are ignored", "assumed: masts and frames of an indoor robot"},
    {"the robot in its own sweeps", "rows with the same range at this bearing, at least", kBodyRows, "the same", "as in single scans"},
    {"the robot in its own sweeps", "places, 0.3 m apart, where the laser would have to see the same object, at least", kBodyPlaces, "the same", "two walls are often at equal distance"},
    {"the robot in its own sweeps", "fraction of the places at this bearing where it does, at least", kBodyPart, "the same", "as in single scans"},
    {"the robot in its own sweeps", "of them, places that other beams pass through, at least", kSeenThrough, "the same", "floors and walls along the path stop all beams"},
    {"the robot in its own sweeps", "the same over those that other beams reach, at least", kSeenThroughPart, "the same", "the same"},
};
// clang-format on

}  // namespace marco::mapping3d::sweep_gates
