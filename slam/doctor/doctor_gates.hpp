#pragma once

#include "common/gate.hpp"
#include "slam/doctor/diagnosis.hpp"

namespace marco::slam::doctor_gates {

// Doors, chairs and panes of glass contradict, too. Walls that are drawn twice reach 0.5 to 1.
inline constexpr double kContradicting = 0.30, kContradictingWrong = 0.50;
inline constexpr int kFewestRefused = 2;
inline constexpr double kLoopMovesM = 0.30;
inline constexpr double kSurprise = 100.0;
// A step of a keyframe to the next one.
inline constexpr double kWeakM = 0.30, kWeakDeg = 5.0;
// Without odometry nobody contradicts scans that slide along a hall, and they think themselves
// sure.
inline constexpr double kWeakAloneM = 0.045;
inline constexpr double kSpreadM = 0.30;
inline constexpr double kDisagreementM = 0.30;
inline constexpr double kUnmatched = 0.2, kUnmatchedWrong = 0.5;
inline constexpr double kBlind = 0.5;
inline constexpr double kBreakSigmas = 6.0;

// clang-format off
/// Every rule that makes a map doubtful or wrong.
inline constexpr Gate kDoctorGates[] = {
    {"contradiction", "fraction of the points that an earlier pass saw elsewhere, over twelve keyframes, at least", kContradicting, "doubtful", "a kitchen whose map is right has 0.25"},
    {"contradiction", "the same", kContradictingWrong, "wrong", "walls that are drawn twice reach 0.5 to 1"},
    {"refused loops", "loops that would move the map by the next row and match better, at least", kFewestRefused, "doubtful", "a single one may be a false candidate"},
    {"refused loops", "how far a loop would move the map [m], at least", kLoopMovesM, "counted in the row before", "assumed"},
    {"surprising loop", "squared Mahalanobis distance of a loop in force from all the rest, at least", kSurprise, "doubtful", "assumed: ten standard deviations"},
    {"weak joint", "standard deviation of a step that no odometry confirms [m], more than", kWeakM, "doubtful", "assumed"},
    {"weak joint", "the same without any odometry [m], more than", kWeakAloneM, "doubtful", "assumed: scans alone are overconfident in halls"},
    {"weak joint", "standard deviation of its turn [deg], more than", kWeakDeg, "doubtful", "assumed"},
    {"weak joint", "standard deviation of a step [m], more than", kSurelyWrongM, "wrong", "assumed"},
    {"disagreement", "distance of the map from the one made of steps and loops alone [m], at least", kDisagreementM, "doubtful", "75 good simulated maps had 0.14 at most, seven real logs 0.16; of 29 wrong ones 18 had more"},
    {"disagreement", "the same, more than", kSurelyWrongM, "wrong", "assumed"},
    {"spread", "how far 2 % of the keyframes may be off, given steps and loops [m], at least", kSpreadM, "doubtful", "none of 53 good simulated maps and seven real logs had more than 0.24"},
    {"unmatched scans", "fraction of the scans that did not match the map, at least", kUnmatched, "doubtful", "of 137 good simulated maps two left more than 0.12, 0.25 and 0.30; of 75 wrong ones 23 left more"},
    {"unmatched scans", "the same", kUnmatchedWrong, "wrong", "of 75 wrong simulated maps 12 left more, of 137 good ones none"},
    {"blind scans", "fraction of the scans that saw too little to be matched, at least", kBlind, "doubtful; wrong without any keyframe", "most of the path does not come from scans"},
    {"odometry break", "standard deviations by which map and odometry diverge, with noise estimated from the log, more than", kBreakSigmas, "doubtful", "assumed"},
    {"odometry break", "difference in distance between the map and trusted odometry [m], more than", kSurelyWrongM, "wrong", "assumed"},
};
// clang-format on

}  // namespace marco::slam::doctor_gates
