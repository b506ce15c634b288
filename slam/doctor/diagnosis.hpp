#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "slam/map/map_edit.hpp"

namespace marco::slam {

enum class Verdict { good, doubtful, wrong };
const char* to_string(Verdict verdict);

/// A map with a part that is off by this much is wrong, whatever shows it.
inline constexpr double kSurelyWrongM = 1.0;

/// Evidence against a map.
struct Reason {
  enum class Cause {
    contradiction,    ///< one pass saw walls where another saw free space
    refused_loops,    ///< loops that were found, would move the map, and are not in force
    surprising_loop,  ///< a loop in force that all the rest contradicts
    weak_joint,       ///< a step that neither the scans nor the odometry know well
    odometry_break,   ///< a stretch over which map and odometry part
    unmatched_scans,  ///< too few of the scans lie on the map, or could
    disagreement,     ///< scans laid on each other, and steps and loops, give two different maps
    spread            ///< steps and loops leave open where parts of the map lie to each other
  };

  Verdict verdict = Verdict::doubtful;
  Cause cause = Cause::contradiction;
  Utime from;  ///< the stretch of the path that is meant
  Utime to;
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();  ///< world
  std::string why;                                    ///< for a person, in a sentence without end
  MapEdits remedies;                        ///< suggested fixes, the likeliest first; may be empty
  std::vector<int> older_keys, newer_keys;  ///< keyframes that show it

  /// False: it is about the whole map.
  bool has_place() const { return !older_keys.empty() || !newer_keys.empty(); }
};
const char* to_string(Reason::Cause cause);

/// What the verdict is made of; worst of the map each.
struct DoctorFigures {
  double contradicting = 0.0;         ///< part of the points, over a stretch of path
  double contradicting_in_all = 0.0;  ///< the same of the whole map
  double confirmed_keyframes = 0.0;   ///< part of the keyframes on whose walls other passes agree
  int refused_loops = 0;              ///< that would move the map by more than 0.3 m
  double refused_loop_m = 0.0;        ///< by how much
  double loop_surprise = 0.0;  ///< squared distance in standard deviations, of loops in force
  double joint_m = 0.0;        ///< standard deviation of a step
  double joint_deg = 0.0;
  double unmatched = 0.0;         ///< part of the scans that were not laid on the map
  double blind = 0.0;             ///< part of the scans that saw too little to be matched
  double disagreement_m = 0.0;    ///< of the map with its pose graph, at most
  double spread_m = 0.0;          ///< by which 2 % of the keyframes may be off, by steps and loops
  bool has_odometry = false;      ///< one that moves
  double odometry_sigmas = 0.0;   ///< of the worst break
  double turn_correlation = 0.0;  ///< of scans and odometry
  double way_correlation = 0.0;   ///< wherever the laser looks; negative: it looks back

  /// Wheels that go with the map so well are believed where it parts from them.
  bool odometry_is_believed() const {
    constexpr double kBelieved = 0.9;  // four fifths of the variance of all motions are explained
    return has_odometry && turn_correlation > kBelieved && std::abs(way_correlation) > kBelieved;
  }

  template <class Visitor>
  void visit(Visitor& v) {
    v("contradicting", contradicting);
    v("contradicting_in_all", contradicting_in_all);
    v("confirmed_keyframes", confirmed_keyframes);
    v("refused_loops", refused_loops);
    v("refused_loop_m", refused_loop_m);
    v("loop_surprise", loop_surprise);
    v("joint_m", joint_m);
    v("joint_deg", joint_deg);
    v("unmatched", unmatched);
    v("blind", blind);
    v("disagreement_m", disagreement_m);
    v("spread_m", spread_m);
    v("has_odometry", has_odometry);
    v("odometry_sigmas", odometry_sigmas);
    v("turn_correlation", turn_correlation);
    v("way_correlation", way_correlation);
  }
};

struct Diagnosis {
  Verdict verdict = Verdict::good;
  std::vector<Reason> reasons;  ///< the worst first
  /// What the recording leaves open of the whole map, and what settles it: a sentence each.
  std::vector<std::string> open_questions;
  DoctorFigures figures;

  void ask(std::string question) {
    open_questions.push_back(std::move(question));
    verdict = std::max(verdict, Verdict::doubtful);
  }
};

}  // namespace marco::slam
