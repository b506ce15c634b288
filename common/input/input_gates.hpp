#pragma once

#include "common/gate.hpp"

namespace marco::input_gates {

// Outdoors a laser of 80 m has a median of 20 m.
inline constexpr double kNobodySeesM = 100.0;
// A room of 3 m is 300 cm or 3000 mm.
inline constexpr double kMillimetresFromM = 800.0;
// Of steps between two samples of odometry that move. A robot that runs indoors does 3 m/s and 5
// rad/s; one of 0.3 m/s and 0.3 rad/s in millimetres and degrees 300 and 17.
inline constexpr double kFastestRobotMPerS = 15.0, kFastestTurnRadPerS = 10.0;
inline constexpr double kTooFastPart = 0.25;
// A second laser of the same kind makes it 2; one of half the rate 1.5.
inline constexpr double kTooFast = 1.4;
// A verdict is asked for after each scan, and neighbouring scans err alike.
inline constexpr double kSureSigmas = 3.5;
// Lasers turn 3 to 50 times a second.
inline constexpr double kFastestS = 0.02, kSlowestS = 0.35;
inline constexpr double kJitter = 0.3;  // of a period
// Of two stamps of a stalled logger at most: of a period.
inline constexpr double kStalled = 0.15;
// A robot that is seen from aboard is near, and beside its parts the view is free. A wall that is
// followed closely continues.
inline constexpr double kBodyWithinM = 1.0;
inline constexpr int kBodyScans = 20;
inline constexpr double kBodyPart = 0.8;
inline constexpr double kChangedPart = 0.4;
inline constexpr double kFreeBeside = 0.6;
inline constexpr double kFloorPart = 0.1, kBeyondFloor = 0.02;
// A wall stands where it is when the robot turns.
inline constexpr double kFloorFree = 0.5;

// clang-format off
/// Rules that decide what is wrong with a sensor's data before anything is mapped.
inline constexpr Gate kInputGates[] = {
    {"unit of the ranges", "median range [m], more than", kNobodySeesM, "refused: ranges are in centimetres", "outdoors a laser of 80 m has a median of 20 m"},
    {"unit of the ranges", "median range [m], at least", kMillimetresFromM, "refused: ranges are in millimetres", "a room of 3 m is 300 cm or 3000 mm"},
    {"unit of the odometry", "speed between two moving samples [m/s], more than", kFastestRobotMPerS, "the step counts as too fast", "0.3 m/s in millimetres is 300"},
    {"unit of the odometry", "turn rate between two turning samples [rad/s], more than", kFastestTurnRadPerS, "the step counts as too fast", "0.3 rad/s in degrees is 17"},
    {"unit of the odometry", "fraction of the moving steps that are too fast, at least", kTooFastPart, "odometry is ignored", "assumed: people drive faster than 0.2 rad/s in a quarter of all turns"},
    {"second sender", "rate of a channel relative to its usual rate, more than", kTooFast, "reported: probably a second sender", "a second laser with half the rate gives 1.5"},
    {"unit of the beam times", "time of one turn [s], less than", kFastestS, "rescaled, if another unit makes it plausible", "lasers turn 3 to 50 times a second"},
    {"unit of the beam times", "the same, more than", kSlowestS, "the same", "the same"},
    {"order of the beams", "standard deviations by which another order matches turning scans better, more than", kSureSigmas, "beam times are corrected", "tested after each scan, and errors of neighbouring scans are correlated"},
    {"bursts of stamps", "how early a stamp is [periods], more than", kJitter, "moved to the regular time, with the next row", "stamps of loggers in real recordings"},
    {"bursts of stamps", "periods between two stamps of a stalled logger, less than", kStalled, "moved to the regular time, with the row before", "no laser is so fast"},
    {"the robot in its own view", "range [m], at most", kBodyWithinM, "its returns at this bearing are ignored", "the robot's own parts are near"},
    {"the robot in its own view", "scans of changing scenes with the same range at this bearing, at least", kBodyScans, "the same", "finds posts added to intel, and none in recordings without posts"},
    {"the robot in its own view", "the same over all of them, at least", kBodyPart, "the same", "the same"},
    {"the robot in its own view", "fraction of these scans in which the view is free on both sides, at least", kFreeBeside, "the same", "a wall along the path continues"},
    {"the robot in its own view", "fraction of the bearings whose range changed, at least", kChangedPart, "the scan counts", "a standing robot shows nothing"},
    {"the floor in view", "fraction of the returns on one line of the laser's frame, more than", kFloorPart, "the map is made again without them", "simulated flats, a laser pitched by 5 degrees"},
    {"the floor in view", "fraction of the returns beyond the line, at most", kBeyondFloor, "the same", "a laser cannot see through a floor; a robot pitches"},
    {"the floor in view", "fraction of the line's returns seen as free from nearby, after a turn, more than", kFloorFree, "the same", "a wall stays when the robot turns: 0.002 in rings of corridors, 0.7 and more for floors"},
};
// clang-format on

}  // namespace marco::input_gates
