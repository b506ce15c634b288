#pragma once

#include "common/covariance.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

// clang-format off
/// The gate table: every rule that decides whether a match is used, repeated more widely, refused, or drawn.
///
/// | gate               | quantity                     | threshold              | then                            | without it                             |
/// |--------------------|------------------------------|------------------------|---------------------------------|----------------------------------------|
/// | too few points     | returns of the scan          | min_points             | not matched                     | a scan of nothing would match          |
/// | odometry is doubted| overlap                      | sure_overlap           | matched with a weak prior, too  | lost odometry 0.63 -> 2.85 m           |
/// | - it is wrong      | overlap gained; distance     | kProvesLie; kContradiction | that match is used          | office 0.08 m at worst; 6 m range 0.03 -> 0.07 m |
/// | - it is left behind| squared distance by odometry over up to a second; overlap lost | kContradiction; kProvesLie | matched where odometry says | 5.6 m range in a corridor: stops at 10.2 of 11.1 m |
/// | match widely       | overlap, or no odometry      | good_overlap           | searched in the prior's window  | 6 m range 0.03 -> 2.6 m                |
/// | - it is better     | overlap gained               | kClearlyBetter         | the search's match is used      | no odometry 2.0 -> 2.7 m               |
/// | match widest       | no usable match              | good_overlap           | searched without odometry       | no odometry 2.0 -> 7.0 m               |
/// | turned otherwise   | overlap, long scans          | sure_overlap           | deskewed by other turn rates, too | rovers that turn back at once 0.012 -> 4 m |
/// | - against odometry | the same                     | good_overlap           | the same                        | odometry that never moves 0.009 -> 0.048 m |
/// | no match           | overlap                      | poor_overlap           | predicted                       | lost odometry 0.63 -> 1.1 m            |
/// | innovation         | jump from the pose before    | exceeds_motion_limits, kJumpsUntilBelievedS | predicted, not drawn | lost odometry 0.63 -> 1.4 m  |
/// | fits nothing       | unmatched scans in a row     | kUnmatchedUntilDrawn   | not drawn                       | 6 m range 0.03 -> 2.6 m                |
/// | stands still       | squared Mahalanobis distance | kContradiction         | zero velocity update ends       | no odometry 2.0 -> 2.5 m               |
///
/// Source of the last column: our experiment. The mean translation error of intel.log against its relations, where
/// odometry stands still for 600 s ("lost odometry") or always ("no odometry"), or the laser sees 6 m by a third of its
/// beams; and the simulated office. On the unaltered logs no gate costs more than 0.1 mm.
// clang-format on
struct MatchGateOptions {
  int min_points = 20;         ///< a scan with fewer returns is not matched
  double sure_overlap = 0.8;   ///< below it odometry may lie: the scan is matched without it, too
  double good_overlap = 0.5;   ///< below it the search is widened
  double poor_overlap = 0.25;  ///< below it the match is not used

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_points", min_points, Limits{3, 100000},
      "Scans with fewer returns are not matched. Less for lasers with few beams.");
    v.advanced("good_overlap", good_overlap, Limits{0.0, 1.0},
               "A match that overlaps the local map less is repeated with a wider search.");
    v.advanced("poor_overlap", poor_overlap, Limits{0.0, 1.0},
               "Matches that overlap less are rejected. Less among many people.");
  }
};

namespace match_gates {

// By how much more of the points another match must explain to be taken instead.
inline constexpr double kClearlyBetter = 0.05;

// The same where odometry must have lied for it.
inline constexpr double kProvesLie = 0.10;

// What is left of the information of odometry that the scan contradicts.
inline constexpr double kDoubtedPrior = 0.01;

// The window of a search: three standard deviations of the prediction, within these limits. The
// widest is searched where odometry is contradicted.
inline constexpr double kSigmas = 3.0;
inline constexpr double kNarrowestM = 0.3, kNarrowestDeg = 5.0;
inline constexpr double kWidestM = 1.5, kWidestDeg = 45.0;
inline constexpr double kMinSearchScore = 0.2;

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
}  // namespace marco::slam
