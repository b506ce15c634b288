#pragma once

#include <vector>

namespace marco::slam {

struct WallEvidenceOptions {
  double bin_m = 0.10;               ///< length of a piece
  double hit_log_odds = 0.5;         ///< gained in a scan that sees the piece
  double passed_log_odds = 0.9;      ///< lost in a scan whose rays went through it
  double limit_log_odds = 4.0;       ///< lets a door open that was shut for long
  double seen_probability = 0.5;     ///< likelier pieces belong to the plan
  double forget_probability = 0.12;  ///< a wall with no likelier piece is removed
};

/// Log odds that a wall still stands, in pieces along it: the time-dependent landmark that thesis A
/// asks for. A door that opens takes its piece out of the plan, not the whole wall. Votes are
/// collected during a scan, then counted: each piece gains or loses once per scan, however many
/// beams met it. Lengths are measured from the wall's present start.
class WallEvidence {
 public:
  struct Run {
    double from_m;
    double to_m;
  };

  WallEvidence() = default;
  /// A new wall, seen once over all its length.
  WallEvidence(const WallEvidenceOptions& options, double length_m);

  /// The wall was lengthened, by before_start_m at its start. Added pieces are unknown until seen.
  void set_extent(double before_start_m, double length_m);

  void vote_hit(double at_m) { vote(at_m, 1); }
  void vote_passed(double at_m) { vote(at_m, -1); }
  void count_votes(const WallEvidenceOptions& options);
  /// Of what was seen, that it was seen once.
  void forget(const WallEvidenceOptions& options);

  /// Takes over the evidence of another wall, whose start lies `offset_m` after this one's.
  void merge(const WallEvidence& other, double offset_m);

  /// Probability of the surest piece.
  double existence() const;
  /// Stretches that are likelier than options.seen_probability.
  std::vector<Run> runs(const WallEvidenceOptions& options) const;

  /// What is stored.
  template <class Visitor>
  void visit(Visitor& v) {
    v("bin_m", bin_m_);
    v("offset_m", offset_m_);
    v("length_m", length_m_);
    v("log_odds", log_odds_);
  }

 private:
  void vote(double at_m, int value);

  double bin_m_ = 0.1;
  double offset_m_ = 0.0;  ///< the wall's start, measured from the border of the first bin
  double length_m_ = 0.0;
  std::vector<float> log_odds_;
  std::vector<int> votes_;  ///< of this scan; empty between scans
};

}  // namespace marco::slam
