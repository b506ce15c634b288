#pragma once

#include "common/covariance.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

/// Every rule that decides whether a match is used, repeated more widely, refused, or drawn.
/// Figures: what switching the rule off costs, see the table in docs of the commit that made it.
struct MatchGateOptions {
  int min_points = 20;         ///< a scan with fewer returns is not matched
  double sure_overlap = 0.8;   ///< below it odometry may lie: the scan is matched without it, too
  double good_overlap = 0.5;   ///< below it the search is widened
  double poor_overlap = 0.25;  ///< below it the match is not used

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_points", min_points, Limits{3, 100000});
    v("sure_overlap", sure_overlap, Limits{0.0, 1.0});
    v("good_overlap", good_overlap, Limits{0.0, 1.0});
    v("poor_overlap", poor_overlap, Limits{0.0, 1.0});
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

// Squared Mahalanobis distance beyond which one measurement contradicts another.
inline constexpr double kContradiction = kChi2Dof3Quantile999;

}  // namespace match_gates
}  // namespace marco::slam
