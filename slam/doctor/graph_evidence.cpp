#include "slam/doctor/graph_evidence.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "slam/back_end/graph/edge_judgement.hpp"
#include "slam/doctor/contradictions.hpp"

namespace marco::slam {
namespace {

constexpr double kMovesM = 0.30;
constexpr int kFewestRefused = 2;  // one alone may be the loop search's mistake
constexpr double kSurprise = 100.0;
// A step of a keyframe to the next one.
constexpr double kWeakM = 0.30, kWeakDeg = 5.0;
// Without odometry nobody contradicts scans that slide along a hall, and they think themselves
// sure.
constexpr double kWeakAloneM = 0.045;

struct JudgedEdge {
  const PoseGraphEdge* edge;
  const Loop* loop;  // nullptr: none
  EdgeJudgement judgement;
  double off_m;
};

std::vector<JudgedEdge> judge(const MapEvidence& map) {
  PoseGraph graph;
  for (const Keyframe& key : map.keys) graph.add_node(key.world_from_robot);
  std::vector<bool> in_force;
  std::vector<JudgedEdge> judged;
  std::size_t loop = 0;
  for (const PoseGraphEdge& edge : map.edges) {
    graph.add_edge(edge);
    const Loop* of_edge = edge.is_loop ? &map.loops[loop++] : nullptr;
    in_force.push_back(of_edge == nullptr || of_edge->is_inlier);
    judged.push_back({&edge, of_edge, {}, 0.0});
  }
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
  }
  return judged;
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

template <class... Values>
std::string sentence(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

// Rooms that look alike give loops that are rightly refused: there the map fits as well.
bool fits_better(const std::vector<Keyframe>& keys, const Loop& loop) {
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
    if (edge.loop == nullptr || edge.loop->is_inlier || edge.off_m < kMovesM) continue;
    if (!fits_better(map.keys, *edge.loop)) continue;
    ++figures.refused_loops;
    figures.refused_loop_m = std::max(figures.refused_loop_m, edge.off_m);
    if (worst == nullptr || edge.loop->overlap > worst->loop->overlap) worst = &edge;
  }
  if (figures.refused_loops < kFewestRefused) return;
  Reason reason = reason_at(map, *worst->edge, Reason::Cause::refused_loops);
  reason.why = sentence("%d loops that would move the map by up to %.2f m were refused",
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
    if (edge.judgement.squared_distance <= diagnosis.figures.loop_surprise) continue;
    diagnosis.figures.loop_surprise = edge.judgement.squared_distance;
    worst = &edge;
  }
  if (diagnosis.figures.loop_surprise < kSurprise) return;
  Reason reason = reason_at(map, *worst->edge, Reason::Cause::surprising_loop);
  reason.why = sentence("a loop in force is %.1f standard deviations off what all the rest says",
                        std::sqrt(diagnosis.figures.loop_surprise));
  reason.remedies = {edit_of(map, *worst->edge, MapEdit::Kind::forbid_loop)};
  diagnosis.reasons.push_back(std::move(reason));
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
    const double sigma_m = std::sqrt(std::max(
        0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance.topLeftCorner<2, 2>())
                 .eigenvalues()
                 .maxCoeff()));
    const double sigma_deg = rad_to_deg(std::sqrt(std::max(0.0, covariance(2, 2))));
    figures.joint_m = std::max(figures.joint_m, sigma_m);
    figures.joint_deg = std::max(figures.joint_deg, sigma_deg);
    const double part = std::max(sigma_m / most_m, sigma_deg / kWeakDeg);
    if (part <= worst_part) continue;
    worst_part = part;
    worst = &edge;
  }
  if (worst == nullptr) return;
  Reason reason = reason_at(map, *worst->edge, Reason::Cause::weak_joint);
  reason.why =
      sentence("what lies before and after hangs together by a step known to %.2f m and %.1f deg%s",
               figures.joint_m, figures.joint_deg,
               figures.has_odometry ? "" : ", and no odometry says how far it was");
  diagnosis.reasons.push_back(std::move(reason));
}

int nearest_key(const std::vector<Keyframe>& keys, Utime utime) {
  const auto off_s = [utime](const Keyframe& key) {
    return std::abs((key.utime - utime).seconds());
  };
  const auto found = std::min_element(
      keys.begin(), keys.end(), [&](const auto& a, const auto& b) { return off_s(a) < off_s(b); });
  return static_cast<int>(found - keys.begin());
}

}  // namespace

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

void examine_graph(const MapEvidence& map, Diagnosis& diagnosis) {
  if (map.keys.size() < 2 || map.edges.empty()) return;
  const std::vector<JudgedEdge> edges = judge(map);
  add_refused_loops(map, edges, diagnosis);
  add_surprising_loop(map, edges, diagnosis);
  add_weak_joint(map, edges, diagnosis);
}

}  // namespace marco::slam
