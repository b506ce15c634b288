#pragma once

#include <vector>

#include "lcm_tools/base/options.hpp"

namespace marco::slam {

struct WallEvidenceOptions {
  double bin_m = 0.10;               ///< walls are believed in piece by piece of this length
  double hit_log_odds = 0.5;         ///< gained in a scan that sees the piece
  double passed_log_odds = 0.9;      ///< lost in a scan whose rays went through it
  double limit_log_odds = 4.0;       ///< so that a door that was shut for a year can still open
  double seen_probability = 0.5;     ///< pieces likelier than this belong to the plan
  double forget_probability = 0.12;  ///< a wall none of whose pieces is likelier is removed

  template <class Visitor>
  void visit(Visitor& v) {
    v("bin_m", bin_m, Limits{0.01, 10.0});
    v("hit_log_odds", hit_log_odds, kPositive);
    v("passed_log_odds", passed_log_odds, kPositive);
    v("limit_log_odds", limit_log_odds, kPositive);
    v("seen_probability", seen_probability, Limits{0.01, 0.99});
    v("forget_probability", forget_probability, Limits{0.0, 0.99});
  }
};

/// How sure it is that a wall still stands, piece by piece along it: the time-dependent landmark
/// that thesis A asks for. A door in a wall that opens takes its piece out of the plan, not the
/// wall. Votes are collected for a scan, then counted: a piece gains or loses once a scan, however
/// many beams met it. Lengths are measured from the wall's present start.
class WallEvidence {
 public:
  struct Run {
    double from_m;
    double to_m;
  };

  WallEvidence() = default;
  /// A new wall, seen once over all its length.
  WallEvidence(const WallEvidenceOptions& options, double length_m);

  /// The wall was lengthened. @param before_start_m  by so much at its start (new start = old one
  /// minus this); pieces added are unknown until they are seen.
  void set_extent(double before_start_m, double length_m);

  void vote_hit(double at_m) { vote(at_m, 1); }
  void vote_passed(double at_m) { vote(at_m, -1); }
  void count_votes(const WallEvidenceOptions& options);

  /// Takes over what another wall knew, whose start lies `offset_m` after this one's.
  void merge(const WallEvidence& other, double offset_m);

  /// Probability of the surest piece.
  double existence() const;
  /// Stretches that are likelier than options.seen_probability.
  std::vector<Run> runs(const WallEvidenceOptions& options) const;

  double length_m() const { return length_m_; }
  double bin_m() const { return bin_m_; }
  const std::vector<float>& log_odds() const { return log_odds_; }
  double offset_m() const { return offset_m_; }
  /// As stored: the reverse of the accessors.
  static WallEvidence restore(double bin_m,
                              double offset_m,
                              double length_m,
                              std::vector<float> log_odds);

 private:
  void vote(double at_m, int value);

  double bin_m_ = 0.1;
  double offset_m_ = 0.0;  ///< the wall's start, measured from the border of the first bin
  double length_m_ = 0.0;
  std::vector<float> log_odds_;
  std::vector<int> votes_;
};

}  // namespace marco::slam
