#include "slam/doctor/doctor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "lcm_tools/base/format.hpp"
#include "slam/back_end/graph/edge_judgement.hpp"
#include "slam/doctor/contradiction_reasons.hpp"
#include "slam/doctor/doctor_gates.hpp"
#include "slam/doctor/graph_evidence.hpp"
#include "slam/doctor/odometry_windows.hpp"

namespace marco::slam {
namespace {

constexpr std::size_t kMostBreaks = 3;  // reported
constexpr std::size_t kMostAsked = 8;   // of the worst: each asks all loops around it

/// How well loops know how the ends of a stretch lie to each other; infinite: not at all.
struct KnownByLoops {
  double sigma_m = std::numeric_limits<double>::infinity();
  double sigma_rad = std::numeric_limits<double>::infinity();
};

int nearest_key(const std::vector<Keyframe>& keys, Utime utime) {
  const auto off_s = [utime](const Keyframe& key) {
    return std::abs((key.utime - utime).seconds());
  };
  const auto found = std::min_element(
      keys.begin(), keys.end(), [&](const auto& a, const auto& b) { return off_s(a) < off_s(b); });
  return static_cast<int>(found - keys.begin());
}

// What is known of the stretch between both times round its own steps. Cost: a factorization of
// the graph.
KnownByLoops known_by_loops(const MapEvidence& map, Utime from, Utime to) {
  // Not 0, so that what hangs by these steps alone does not hang in the air.
  constexpr double kHardlyAtAll = 1e-6;
  if (map.edges.empty()) return {};
  int first = nearest_key(map.keys, from), last = nearest_key(map.keys, to);
  if (first > last) std::swap(first, last);
  if (first == last) return {};
  const auto within = [&](int key) { return key >= first && key <= last; };
  PoseGraph graph;
  for (const Keyframe& key : map.keys) graph.add_node(key.world_from_robot);
  std::vector<double> weights;
  std::size_t loop = 0;
  for (const PoseGraphEdge& edge : map.edges) {
    graph.add_edge(edge);
    const bool refused = edge.is_loop && !map.loops[loop++].is_inlier;
    weights.push_back(refused ? 0.0 : within(edge.from) && within(edge.to) ? kHardlyAtAll : 1.0);
  }
  const Eigen::Matrix3d covariance = relative_covariance(graph, weights, first, last);
  const double m2 = covariance.topLeftCorner<2, 2>().trace(), rad2 = covariance(2, 2);
  KnownByLoops known;
  if (m2 >= 0.0) known.sigma_m = std::sqrt(m2);
  if (rad2 >= 0.0) known.sigma_rad = std::sqrt(rad2);
  return known;
}

Reason reason_of(const OdometryBreak& parted, bool odometry_is_believed) {
  Reason reason;
  reason.cause = Reason::Cause::odometry_break;
  reason.from = std::min(parted.from, parted.to);
  reason.to = std::max(parted.from, parted.to);
  reason.place_m = parted.world_from_end.translation_m();
  reason.why = format(
      "the map moves %.2f m and turns %.1f deg while odometry moves %.2f m and turns "
      "%.1f deg",
      parted.map.translation_m().norm(), rad_to_deg(parted.map.theta_rad),
      parted.odometry.translation_m().norm(), rad_to_deg(parted.odometry.theta_rad));
  if (odometry_is_believed && std::abs(parted.longer_m) > kSurelyWrongM)
    reason.verdict = Verdict::wrong;
  const MapEdit bridge{MapEdit::Kind::drop_scans, reason.from, reason.to, {}};
  const MapEdit distrust{MapEdit::Kind::distrust_odometry, reason.from, reason.to, {}};
  if (odometry_is_believed) reason.remedies.push_back(bridge);
  reason.remedies.push_back(distrust);
  return reason;
}

void add_keyframes_of(const std::vector<Keyframe>& keys, Reason& reason) {
  for (std::size_t key = 0; key < keys.size(); ++key) {
    const bool meant = keys[key].utime >= reason.from && keys[key].utime <= reason.to;
    if (meant) reason.newer_keys.push_back(static_cast<int>(key));
  }
}

// Loops that know the place better by far than both differ say that the map is right there.
bool has_slipped(const MapEvidence& map, const OdometryBreak& parted) {
  constexpr double kSurely = 0.2;  // five standard deviations
  const KnownByLoops known = known_by_loops(map, parted.from, parted.to);
  return known.sigma_m < kSurely * parted.off_m() ||
         (parted.is_turn && known.sigma_rad < kSurely * parted.off_rad());
}

void examine_odometry(const MapEvidence& map, Diagnosis& diagnosis) {
  DoctorFigures& figures = diagnosis.figures;
  for (const RecordedPath& recorded : map.paths) {
    const OdometryAgreement agreement = compare_with_odometry(recorded.path, recorded.odometry);
    if (!agreement.present) continue;
    // Of several recordings the one that agrees least.
    const auto least = [&figures](double so_far, double now) {
      return figures.has_odometry ? std::min(so_far, now) : now;
    };
    figures.turn_correlation = least(figures.turn_correlation, agreement.turn_correlation);
    figures.way_correlation = least(figures.way_correlation, agreement.way_correlation);
    figures.has_odometry = true;
    const bool believed = figures.odometry_is_believed();
    std::size_t told = 0;
    for (std::size_t i = 0; i < agreement.breaks.size() && i < kMostAsked; ++i) {
      const OdometryBreak& parted = agreement.breaks[i];
      if (told == kMostBreaks) break;
      if (has_slipped(map, parted)) continue;
      ++told;
      figures.odometry_sigmas = std::max(figures.odometry_sigmas, parted.sigmas);
      diagnosis.reasons.push_back(reason_of(parted, believed));
      add_keyframes_of(map.keys, diagnosis.reasons.back());
    }
  }
}

Reason reason_of_scans(const MapEvidence& map, Verdict verdict, double part, const char* what) {
  Reason reason;
  reason.cause = Reason::Cause::unmatched_scans;
  reason.verdict = verdict;
  for (const RecordedPath& recorded : map.paths) {
    if (recorded.path.empty()) continue;
    if (reason.to.us == 0) {
      reason.from = recorded.path.front().utime;
      reason.place_m = recorded.path.front().world_from_robot.translation_m();
    }
    reason.to = recorded.path.back().utime;
  }
  reason.why = format("%.0f %% of the scans %s", 100.0 * part, what);
  return reason;
}

// What sees nothing says nothing against the map; but most of the path does not come from scans.
void examine_blindness(const MapEvidence& map, Diagnosis& diagnosis) {
  if (map.blind_scans == 0) return;
  double& blind = diagnosis.figures.blind;
  blind = static_cast<double>(map.blind_scans) / (map.scans + map.blind_scans);
  if (blind < doctor_gates::kBlind) return;
  diagnosis.reasons.push_back(reason_of_scans(map,
                                              map.keys.empty() ? Verdict::wrong : Verdict::doubtful,
                                              blind, "saw too little to be matched with the map"));
}

void examine_matches(const MapEvidence& map, Diagnosis& diagnosis) {
  if (map.scans == 0) return;
  double& unmatched = diagnosis.figures.unmatched;
  unmatched = 1.0 - static_cast<double>(map.matched_scans) / map.scans;
  if (unmatched < doctor_gates::kUnmatched) return;
  diagnosis.reasons.push_back(reason_of_scans(
      map, unmatched < doctor_gates::kUnmatchedWrong ? Verdict::doubtful : Verdict::wrong,
      unmatched, "did not match the map"));
}

// Of 75 good simulated maps none had two kinds of reasons, of 29 wrong ones 16. A spread says what
// is not known, not what is wrong.
bool has_two_causes(const std::vector<Reason>& reasons) {
  std::set<Reason::Cause> causes;
  for (const Reason& reason : reasons) causes.insert(reason.cause);
  causes.erase(Reason::Cause::spread);
  return causes.size() > 1;
}

}  // namespace

const char* to_string(Verdict verdict) {
  constexpr std::array kNames{"good", "doubtful", "wrong"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

const char* to_string(Reason::Cause cause) {
  constexpr std::array kNames{"contradiction",  "refused_loops",   "surprising_loop", "weak_joint",
                              "odometry_break", "unmatched_scans", "disagreement",    "spread"};
  return kNames.at(static_cast<std::size_t>(cause));
}

Diagnosis examine(const MapEvidence& map) {
  Diagnosis diagnosis;
  examine_visits(map, diagnosis);
  examine_matches(map, diagnosis);
  examine_blindness(map, diagnosis);
  examine_odometry(map, diagnosis);
  examine_graph(map, diagnosis);
  std::stable_sort(diagnosis.reasons.begin(), diagnosis.reasons.end(),
                   [](const Reason& a, const Reason& b) { return a.verdict > b.verdict; });
  if (!diagnosis.reasons.empty()) diagnosis.verdict = diagnosis.reasons.front().verdict;
  if (has_two_causes(diagnosis.reasons)) diagnosis.verdict = Verdict::wrong;
  return diagnosis;
}

}  // namespace marco::slam
