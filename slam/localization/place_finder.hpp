#pragma once

#include <optional>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "slam/localization/place_map.hpp"
#include "slam/localization/place_search.hpp"

namespace marco::slam {

struct PlaceFinderOptions {
  double memory_m = 8.0;      ///< of path: the last keyframes that are looked at together
  double thin_m = 0.10;       ///< of their points one a square of this size is used
  int search_points = 80;     ///< of these are scored in the exhaustive search
  double min_score = 0.50;    ///< minimum mean likelihood of a candidate
  double keep_within = 0.12;  ///< of the best score: other places that stay in the race
  int max_candidates = 24;    ///< with this many none is believed: others were cut off
  double apart_m = 0.5;       ///< candidates nearer than this, and turned less than ...
  double apart_deg = 10.0;    ///< ... this, are one
  // When one candidate is believed:
  double sure_explained = 0.70;     ///< part of the points that lie on walls of the map
  double sure_evidence = 0.50;      ///< that, less the part that contradicts the map
  double sure_contradicted = 0.08;  ///< no more than so much, whatever else is explained
  /// Or, where much of the scan is not in the map: this part is, and hardly anything contradicts.
  double known_explained = 0.45;
  double known_contradicted = 0.05;
  /// Evidence above that of any other candidate: this, and this part of what the best lacks. Where
  /// the world has changed since, what is the right place explains less.
  double sure_margin = 0.05;
  double margin_scale_with_unexplained = 0.3;
  double sure_path_m = 1.0;  ///< driven since the first keyframe
  int sure_times = 3;        ///< keyframes in a row that say the same

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("memory_m", memory_m, kPositive,
               "Keyframes of the last metres of path that are compared with the map together.");
    v.advanced("max_candidates", max_candidates, Limits{2, 1000},
               "Number of candidate places. If the search finds this many, none is accepted. More "
               "for large buildings with similar rooms.");
    v.advanced(
        "sure_explained", sure_explained, Limits{0.0, 1.0},
        "Fraction of the points that must lie on walls of the map. Less where much has changed.");
    v.advanced("sure_margin", sure_margin, Limits{0.0, 1.0},
               "Margin of evidence that the best place needs over any other.");
    v.advanced("sure_path_m", sure_path_m, kNotNegative,
               "A place is accepted after this distance at the earliest. More for similar rooms.");
    v.advanced("sure_times", sure_times, Limits{1, 1000},
               "Number of keyframes in a row that must agree on the place.");
  }
};

/// Where in the map a session may be.
struct PlaceCandidate : Agreement {
  Pose2 map_from_session;
};

struct PlaceEstimate {
  enum class Status {
    not_yet,     ///< no place fits
    candidates,  ///< some do, and none stands out
    localized    ///< one stands alone, for some keyframes in a row
  };

  Status status = Status::not_yet;
  std::vector<PlaceCandidate> candidates;  ///< best first
};

/// Finds a robot that may be anywhere in a map. The last metres of its own path, as small a map as
/// scan matching is good for, are searched over the whole map and all headings by branch and bound
/// (Hess et al., ICRA 2016, algorithm 3, but keeping all places whose score comes near the best);
/// each place found is refined (Gauss-Newton on the likelihood, Kohlbrecher et al., SSRR 2011) and
/// judged by what it explains and what contradicts it. A place is believed only when no other comes
/// near it, over some keyframes in a row: in a building that repeats itself it stays with
/// candidates until something distinguishes them. Deterministic. Not thread-safe.
class PlaceFinder {
 public:
  /// @param map  outlives the finder.
  PlaceFinder(const PlaceMap& map, const PlaceFinderOptions& options);

  /// Call once a new keyframe. @param session  the session's keyframes with their poses in its own
  /// frame, the newest last; at least one.
  PlaceEstimate look(const std::vector<Keyframe>& session);

  /// What follows is another session.
  void restart();
  /// Whether one place stood out at the last look.
  bool has_leader() const { return leader_times_ > 0; }

 private:
  struct SessionPoints {
    Pose2 session_from_middle;
    Beams beams;  ///< about their mean
  };
  SessionPoints points_of(const std::vector<Keyframe>& session) const;
  std::vector<Pose2> search(const SessionPoints& points) const;
  Pose2 refine(const SessionPoints& points, const Pose2& map_from_middle) const;
  PlaceCandidate judge(const SessionPoints& points, const Pose2& map_from_middle) const;
  void keep_apart(std::vector<PlaceCandidate>& candidates, const Pose2& session_from_robot) const;
  bool near(const Pose2& a, const Pose2& b) const;
  bool stands_out(const std::vector<PlaceCandidate>& found) const;

  const PlaceMap* map_;
  PlaceFinderOptions options_;
  std::vector<Pose2> earlier_;   ///< candidates of the look before, map_from_session
  std::optional<Pose2> leader_;  ///< stood out at the look before
  int leader_times_ = 0;         ///< looks in a row
};

}  // namespace marco::slam
