#include "slam/doctor/graph_evidence.hpp"

#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"
#include "common/linear_algebra.hpp"
#include "common/rigid_fit.hpp"
#include "lcm_tools/base/format.hpp"
#include "slam/back_end/graph/edge_judgement.hpp"
#include "slam/back_end/graph/map_spread.hpp"
#include "slam/doctor/doctor_gates.hpp"
#include "slam/doctor/odometry_windows.hpp"
#include "slam/map/visits.hpp"

namespace marco::slam {
namespace {

using namespace doctor_gates;

constexpr double kSpreadPart =
    0.02;  // of the nodes may be off by more: one place alone does not make a map doubtful

struct JudgedEdge {
  const PoseGraphEdge* edge;
  const Loop* loop;  // nullptr: none
  EdgeJudgement judgement;
  double off_m;              // on the map
  Eigen::Vector3d if_alone;  // its error, were it not in force
};

struct JudgedGraph {
  std::vector<JudgedEdge> edges;
  std::vector<Pose2> world_from_nodes;  // at the graph's optimum
  double spread_m;
};

// An edge's error where all others have their way: (I - P Omega)^-1 e by Woodbury's identity, but
// for a direction that only this edge knows.
Eigen::Vector3d error_without(const EdgeJudgement& judgement,
                              const Eigen::Matrix3d& information,
                              const Eigen::Vector3d& error) {
  constexpr double kAlone = 1e-6;  // of an eigenvalue that is 1 where the edge alone knows it
  const auto [squares, axes] = eigenpairs_of(judgement.covariance);
  const Eigen::Matrix3d root = axes * squares.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const auto [leverage, vectors] =
      eigenpairs_of(Eigen::Matrix3d(root.transpose() * information * root));
  Eigen::Vector3d along = vectors.transpose() * root.transpose() * information * error;
  for (int i = 0; i < 3; ++i) {
    const double left = 1.0 - leverage[i];
    along[i] = left > kAlone ? along[i] / left : 0.0;
  }
  return error + root * (vectors * along);
}

// What edges say of each other is read at the graph's own optimum: the map's poses were moved by
// its scans since, and what a stiff edge seems to miss there is no error of its own.
JudgedGraph judge(const MapEvidence& map) {
  PoseGraph graph;
  for (const Keyframe& key : map.keys) graph.add_node(key.world_from_robot);
  std::vector<bool> in_force;
  std::vector<JudgedEdge> judged;
  std::size_t loop = 0;
  for (const PoseGraphEdge& edge : map.edges) {
    graph.add_edge(edge);
    const Loop* of_edge = edge.is_loop ? &map.loops[loop++] : nullptr;
    in_force.push_back(of_edge == nullptr || of_edge->is_inlier);
    judged.push_back({&edge, of_edge, {}, 0.0, Eigen::Vector3d::Zero()});
  }
  const std::vector<double> weights(in_force.begin(), in_force.end());
  graph.optimize_weighted(weights, PoseGraphOptions{}.min_relative_decrease);
  const std::vector<EdgeJudgement> judgements =
      judge_edges(graph, in_force, JudgedEdges::all, PoseGraphOptions{}.loop_rejection_chi2);
  for (std::size_t i = 0; i < judged.size(); ++i) {
    const PoseGraphEdge& edge = map.edges[i];
    judged[i].judgement = judgements[i];
    judged[i].off_m =
        edge_error(edge, map.keys[static_cast<std::size_t>(edge.from)].world_from_robot,
                   map.keys[static_cast<std::size_t>(edge.to)].world_from_robot)
            .head<2>()
            .norm();
    judged[i].if_alone =
        error_without(judgements[i], edge.information,
                      edge_error(edge, graph.poses()[static_cast<std::size_t>(edge.from)],
                                 graph.poses()[static_cast<std::size_t>(edge.to)]));
  }
  return {std::move(judged), graph.poses(), map_spread_m(graph, weights, kSpreadPart)};
}

Reason reason_at(const MapEvidence& map, const PoseGraphEdge& edge, Reason::Cause cause) {
  Reason reason;
  reason.cause = cause;
  const Keyframe& from = map.keys[static_cast<std::size_t>(edge.from)];
  const Keyframe& to = map.keys[static_cast<std::size_t>(edge.to)];
  reason.from = std::min(from.utime, to.utime);
  reason.to = std::max(from.utime, to.utime);
  reason.place_m = to.world_from_robot.translation_m();
  reason.older_keys = {edge.from};
  reason.newer_keys = {edge.to};
  return reason;
}

MapEdit edit_of(const MapEvidence& map, const PoseGraphEdge& edge, MapEdit::Kind kind) {
  const Utime from = map.keys[static_cast<std::size_t>(edge.from)].utime;
  const Utime to = map.keys[static_cast<std::size_t>(edge.to)].utime;
  if (from <= to) return {kind, from, to, edge.from_from_to};
  return {kind, to, from, edge.from_from_to.inverse()};
}

// Rooms that look alike give loops that are rightly refused: there the map fits as well.
bool fits_better(const std::vector<Keyframe>& keys, const Loop& loop) {
  // Times the points that agree as it is; and few that contradict, as people and doors do.
  constexpr double kBetter = 1.2, kContradicted = 0.05;
  const Keyframe& from = keys[static_cast<std::size_t>(loop.from)];
  const Keyframe& to = keys[static_cast<std::size_t>(loop.to)];
  const Visit as_is = compare(from, to, between(from.world_from_robot, to.world_from_robot));
  const Visit as_found = compare(from, to, loop.from_from_to);
  return as_found.agreeing > kBetter * as_is.agreeing &&
         as_is.contradicting > kContradicted * as_is.seen();
}

void add_refused_loops(const MapEvidence& map,
                       const std::vector<JudgedEdge>& edges,
                       Diagnosis& diagnosis) {
  DoctorFigures& figures = diagnosis.figures;
  const JudgedEdge* worst = nullptr;
  for (const JudgedEdge& edge : edges) {
    if (edge.loop == nullptr || edge.loop->is_inlier || edge.off_m < kLoopMovesM) continue;
    if (!fits_better(map.keys, *edge.loop)) continue;
    ++figures.refused_loops;
    figures.refused_loop_m = std::max(figures.refused_loop_m, edge.off_m);
    if (worst == nullptr || edge.loop->overlap > worst->loop->overlap) worst = &edge;
  }
  if (figures.refused_loops < kFewestRefused) return;
  Reason reason = reason_at(map, *worst->edge, Reason::Cause::refused_loops);
  reason.why = format("%d loops that would move the map by up to %.2f m were rejected",
                      figures.refused_loops, figures.refused_loop_m);
  reason.remedies = {edit_of(map, *worst->edge, MapEdit::Kind::add_loop)};
  diagnosis.reasons.push_back(std::move(reason));
}

void add_surprising_loop(const MapEvidence& map,
                         const std::vector<JudgedEdge>& edges,
                         Diagnosis& diagnosis) {
  const JudgedEdge* worst = nullptr;
  for (const JudgedEdge& edge : edges) {
    if (edge.loop == nullptr || !edge.loop->is_inlier) continue;
    const double off_m = edge.if_alone.head<2>().norm();
    const double off_deg = rad_to_deg(std::abs(edge.if_alone.z()));
    if (off_m < kLoopMovesM && off_deg < kWeakDeg) continue;
    if (edge.judgement.squared_distance <= diagnosis.figures.loop_surprise) continue;
    diagnosis.figures.loop_surprise = edge.judgement.squared_distance;
    worst = &edge;
  }
  if (diagnosis.figures.loop_surprise < kSurprise) return;
  Reason reason = reason_at(map, *worst->edge, Reason::Cause::surprising_loop);
  reason.why =
      format("a loop in force deviates from all the rest by %.2f m and %.1f standard deviations",
             worst->if_alone.head<2>().norm(), std::sqrt(diagnosis.figures.loop_surprise));
  reason.remedies = {edit_of(map, *worst->edge, MapEdit::Kind::forbid_loop)};
  diagnosis.reasons.push_back(std::move(reason));
}

// Odometry that is to be believed, and goes as the map does over this step.
bool is_confirmed_by_odometry(const MapEvidence& map,
                              const PoseGraphEdge& edge,
                              const DoctorFigures& figures) {
  if (!figures.odometry_is_believed()) return false;
  const Keyframe& from = map.keys[static_cast<std::size_t>(edge.from)];
  const Keyframe& to = map.keys[static_cast<std::size_t>(edge.to)];
  const Pose2 by_map = between(from.world_from_robot, to.world_from_robot);
  return std::any_of(map.paths.begin(), map.paths.end(), [&](const RecordedPath& recorded) {
    const auto counted = way_by_odometry(recorded.odometry, from.utime, to.utime);
    if (!counted) return false;
    const double longer_m = by_map.translation_m().norm() - counted->translation_m().norm();
    const double turned_rad = normalize_angle(by_map.theta_rad - counted->theta_rad);
    return std::abs(longer_m) < kWeakM && std::abs(turned_rad) < deg_to_rad(kWeakDeg);
  });
}

void add_weak_joint(const MapEvidence& map,
                    const std::vector<JudgedEdge>& edges,
                    Diagnosis& diagnosis) {
  DoctorFigures& figures = diagnosis.figures;
  const double most_m = figures.has_odometry ? kWeakM : kWeakAloneM;
  const JudgedEdge* worst = nullptr;
  double worst_part = 1.0;
  for (const JudgedEdge& edge : edges) {
    if (edge.loop != nullptr) continue;
    const Eigen::Matrix3d& covariance = edge.judgement.covariance;
    const double sigma_m = position_sigma_m(covariance);
    const double sigma_deg = rad_to_deg(std::sqrt(std::max(0.0, covariance(2, 2))));
    const double part = std::max(sigma_m / most_m, sigma_deg / kWeakDeg);
    if (part > 1.0 && is_confirmed_by_odometry(map, *edge.edge, figures)) continue;
    figures.joint_m = std::max(figures.joint_m, sigma_m);
    figures.joint_deg = std::max(figures.joint_deg, sigma_deg);
    if (part <= worst_part) continue;
    worst_part = part;
    worst = &edge;
  }
  if (worst == nullptr) return;
  Reason reason = reason_at(map, *worst->edge, Reason::Cause::weak_joint);
  if (figures.joint_m > kSurelyWrongM) reason.verdict = Verdict::wrong;
  reason.why = format(
      "the parts before and after are joined by a step with a standard deviation of %.2f m and "
      "%.1f deg%s",
      figures.joint_m, figures.joint_deg,
      figures.has_odometry ? "" : ", and no odometry measured its length");
  diagnosis.reasons.push_back(std::move(reason));
}

// How far the map's keyframes are from the graph's, at most, where one is laid on the other.
double farthest_apart_m(const std::vector<Keyframe>& keys, const std::vector<Pose2>& nodes) {
  Eigen::Matrix2Xd ours(2, keys.size()), theirs(2, keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    ours.col(static_cast<Eigen::Index>(i)) = keys[i].world_from_robot.translation_m();
    theirs.col(static_cast<Eigen::Index>(i)) = nodes[i].translation_m();
  }
  return distances_after_fit(theirs, ours).maxCoeff();
}

// Along a bare corridor scans that are laid on each other slide; steps and loops say so.
void add_disagreement(const MapEvidence& map,
                      const std::vector<Pose2>& world_from_nodes,
                      Diagnosis& diagnosis) {
  double& off_m = diagnosis.figures.disagreement_m;
  off_m = farthest_apart_m(map.keys, world_from_nodes);
  if (off_m < kDisagreementM) return;
  Reason reason;
  reason.cause = Reason::Cause::disagreement;
  if (off_m > kSurelyWrongM) reason.verdict = Verdict::wrong;
  reason.from = map.keys.front().utime;
  reason.to = map.keys.back().utime;
  reason.place_m = map.keys.front().world_from_robot.translation_m();
  reason.why = format(
      "matching the scans with each other gives a map up to %.2f m off the one from steps and "
      "loops",
      off_m);
  diagnosis.reasons.push_back(std::move(reason));
}

// Nothing contradicts a map that is bent where nothing holds it. A weak joint says so already.
void add_spread(const MapEvidence& map, double spread_m, Diagnosis& diagnosis) {
  diagnosis.figures.spread_m = spread_m;
  const bool is_told =
      std::any_of(diagnosis.reasons.begin(), diagnosis.reasons.end(),
                  [](const Reason& told) { return told.cause == Reason::Cause::weak_joint; });
  if (spread_m < kSpreadM || is_told) return;
  Reason reason;
  reason.cause = Reason::Cause::spread;
  reason.from = map.keys.front().utime;
  reason.to = map.keys.back().utime;
  reason.place_m = map.keys.front().world_from_robot.translation_m();
  reason.why =
      std::isfinite(spread_m)
          ? format("steps and loops determine the relative pose of the map's parts only to %.2f m",
                   spread_m)
          : "the parts of the map are not connected";
  diagnosis.reasons.push_back(std::move(reason));
}

}  // namespace

void examine_graph(const MapEvidence& map, Diagnosis& diagnosis) {
  if (map.keys.size() < 2 || map.edges.empty()) return;
  const JudgedGraph judged = judge(map);
  add_disagreement(map, judged.world_from_nodes, diagnosis);
  add_refused_loops(map, judged.edges, diagnosis);
  add_surprising_loop(map, judged.edges, diagnosis);
  add_weak_joint(map, judged.edges, diagnosis);
  add_spread(map, judged.spread_m, diagnosis);
}

}  // namespace marco::slam
