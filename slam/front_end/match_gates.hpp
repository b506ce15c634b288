#pragma once

#include "common/covariance.hpp"
#include "common/gate.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

/// Gates of a match that a user may set; kMatchGates below has them all.
struct MatchGateOptions {
  int min_points = 20;         ///< a scan with fewer returns only refines the odometry
  double sure_overlap = 0.8;   ///< below it odometry may lie: the scan is matched without it, too
  double good_overlap = 0.5;   ///< below it the search is widened
  double poor_overlap = 0.25;  ///< below it the match is not used

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_points", min_points, Limits{3, 100000},
      "Scans with fewer returns only refine the odometry. Less for lasers with few beams.");
    v.advanced("good_overlap", good_overlap, Limits{0.0, 1.0},
               "A match that overlaps the local map less is repeated with a wider search.");
    v.advanced("poor_overlap", poor_overlap, Limits{0.0, 1.0},
               "Matches that overlap less are rejected. Less among many people.");
  }
};

namespace match_gates {

// With fewer returns, a scan is not matched at all.
inline constexpr int kFewestPoints = 8;

// By how much more of the points another match must explain to be taken instead.
inline constexpr double kClearlyBetter = 0.05;

// The same where odometry must be wrong for it. With few points the gain may be chance: it then has
// to exceed this many standard deviations of the difference.
inline constexpr double kProvesLie = 0.10, kNoChanceSigmas = 3.0;

// From a start nearer than this the same match is found again.
inline constexpr double kSameStartM = 0.05, kSameStartDeg = 1.0;

// Degrees of freedom of the t distribution by which a prediction counts: of wheels that mostly
// count well, and sometimes slip. At 4 degrees of freedom and more it has a variance.
inline constexpr double kPriorFreedom = 5.0;

// What is left of the information of odometry that the scan contradicts.
inline constexpr double kDoubtedPrior = 0.01;

// The window of a search: three standard deviations of the prediction, within these limits. The
// widest is searched where odometry is contradicted.
inline constexpr double kSigmas = 3.0;
inline constexpr double kNarrowestM = 0.3, kNarrowestDeg = 5.0;
inline constexpr double kWidestM = 1.5, kWidestDeg = 45.0;
inline constexpr double kMinSearchScore = 0.2;

// Of a laser that is covered: part of the returns that are nearer than this, and part of all
// returns that lie in free space. A hand is at 0.2 m, people who stand around a robot are at 0.5 to
// 1 m. In a corridor the other returns lie where its walls are.
inline constexpr double kCoveredPart = 0.7, kCoverWithinM = 1.0, kCoverFreePart = 0.33;

// A scan that fits nothing is drawn only after this many in a row: odometry that jumped has placed
// it, and what is drawn there makes the next ones fit.
inline constexpr int kUnmatchedUntilDrawn = 3;

// Matches that jump from the prediction as no robot can are believed when all do for this long:
// another robot's scans may come between ours, and they fit where that one is.
inline constexpr double kJumpsUntilBelievedS = 1.0;

// Squared Mahalanobis distance beyond which one measurement contradicts another: about the 99.9 %
// quantile, kChi2Dof3Quantile999.
inline constexpr double kContradiction = 16.0;

}  // namespace match_gates

// clang-format off
/// Every rule that decides whether a match is used, repeated more widely, refused, or drawn. The last column says what a map
/// loses without it: the mean translation error of intel.log against its relations, where odometry stands still for 600 s
/// ("lost odometry") or always ("no odometry"), or the laser sees 6 m by a third of its beams; and the simulated office. On
/// the unaltered logs no gate costs more than 0.1 mm.
inline constexpr Gate kMatchGates[] = {
    {"too few points", "returns of the scan, fewer than", static_cast<double>(MatchGateOptions{}.min_points), "matched near the odometry only, with fixed heading if they show a single object; without odometry not matched", "slam.min_points; without it: columns seen one at a time, 30 m, 0.0 → 4 m"},
    {"too few points for odometry", "returns of the scan, fewer than", static_cast<double>(match_gates::kFewestPoints), "not matched", "at 20: a hall of columns, every second beam, 0.03 → 0.11 m"},
    {"covered: near", "fraction of the returns within 1 m, more than", match_gates::kCoveredPart, "with the next row: not matched, not drawn", "without it: intel, a hand in front of the laser eight times for 3 s, 0.015 → 5.3 m"},
    {"covered: in free space", "fraction of the returns in space that the last keyframes saw as free, more than; while the cover lasts, any", match_gates::kCoverFreePart, "with the row before: not matched, not drawn", "at 0.7: intel, a box over the robot eight times for 10 s, 0.02 → 8.2 m"},
    {"freely: poor fit", "overlap of a match near the odometry, less than", MatchGateOptions{}.sure_overlap, "also matched from where the scan alone fits; the more probable pose is used", "without it: wheels that count reverse as forward, 0.005 → 0.20 m"},
    {"freely: contradiction", "squared Mahalanobis distance of that match from the odometry, more than", match_gates::kContradiction, "the same", "without it: wheels that slip for 2 m, 0.005 → 0.12 m"},
    {"odometry jumps: gain", "overlap gained at the constant-velocity prediction, more than", match_gates::kProvesLie, "with the next row: the match there is used", "without it: a hall, a jump of 70 degrees, 0.004 → 6.7 m"},
    {"odometry jumps: significance", "the same, in standard deviations of its sampling error, more than", match_gates::kNoChanceSigmas, "with the row before: the match there is used", "without it: an office, 26 beams, 0.013 → 0.24 m"},
    {"wide search", "overlap, less than", MatchGateOptions{}.good_overlap, "searched in the prior's window", "slam.good_overlap; without it: 6 m range 0.03 → 2.6 m"},
    {"wide match is better", "overlap gained, more than", match_gates::kClearlyBetter, "the search's match is used", "without it: no odometry 2.0 → 2.7 m"},
    {"other turn rate", "overlap of a long scan, less than", MatchGateOptions{}.sure_overlap, "also deskewed by other turn rates", "without it: rovers that reverse their turn 0.012 → 4 m"},
    {"other turn rate, against odometry", "the same, less than", MatchGateOptions{}.good_overlap, "the same", "without it: odometry that never moves 0.009 → 0.048 m"},
    {"no match", "overlap, less than", MatchGateOptions{}.poor_overlap, "the pose is the prediction", "slam.poor_overlap; without it: lost odometry 0.63 → 1.1 m"},
    {"innovation", "time during which every match jumps impossibly far [s], less than", match_gates::kJumpsUntilBelievedS, "the pose is the prediction, and nothing is drawn", "without it: lost odometry 0.63 → 1.4 m"},
    {"unmatched", "unmatched scans in a row, less than", static_cast<double>(match_gates::kUnmatchedUntilDrawn), "not drawn", "without it: 6 m range 0.03 → 2.6 m"},
    {"standing", "squared Mahalanobis distance of the match, more than", match_gates::kContradiction, "the zero velocity update ends", "without it: no odometry 2.0 → 2.5 m"},
};
// clang-format on
}  // namespace marco::slam
