#include "slam/line_slam/line_mapper.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/map/keyframe_grid.hpp"

namespace marco::slam {
namespace {

Eigen::Matrix3d diagonal_covariance(double sigma_m, double sigma_deg) {
  const double sigma_rad = deg_to_rad(sigma_deg);
  return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
}

void check(const LineMapper::Stored& stored) {
  require(stored.key_beams.size() == stored.keys.size(),
          "line_mapper: beams are not of each keyframe");
  require(stored.keys.empty() || stored.slam.filter.has_mark,
          "line_mapper: the last keyframe's pose is lost");
  // What holds for the scan SLAM's graph holds for this one.
  SlamState graph;
  graph.keyframes.keys = stored.keys;
  graph.back_end.edges = stored.edges;
  graph.back_end.loops = stored.loops;
  graph.path.scans = stored.scans;
  graph.path.keyframe_poses.resize(stored.keys.size(), ScanPose{{}, 0, {}});
  graph.estimate.world_from_robot = Pose2::from_vector(stored.slam.filter.mean.head<3>());
  check(graph);
}

}  // namespace

LineMapper::LineMapper(const LineMapperOptions& options, const Pose2& world_from_robot)
    : options_(options),
      slam_(options.lines, world_from_robot),
      loop_closer_(options.loops, CorrelativeMatcher(options.coarse), SurfelMatcher(options.fine)),
      graph_(options.graph) {
  validate(options, "line_mapper");
}

LineSlamUpdate LineMapper::process(const ScanInRobot& scan,
                                   Utime utime,
                                   const std::optional<Pose2>& robot_motion,
                                   MapUse use,
                                   LineSlamJournal* journal) {
  LineSlamUpdate update = slam_.process(scan, robot_motion, use, journal);
  if (use == MapUse::draw && update.looked && key_is_due()) {
    add_key(scan, utime);
    update.trajectory_changed = close_loops();
    update.world_from_robot = slam_.world_from_robot();
    update.covariance = slam_.filter().robot_covariance();
  }
  note_pose(utime);
  return update;
}

LineSlamUpdate LineMapper::carry(Utime utime, const Pose2& robot_motion) {
  LineSlamUpdate update = slam_.carry(robot_motion);
  note_pose(utime);
  return update;
}

void LineMapper::note_pose(Utime utime) {
  const auto since = slam_.filter().since_mark();
  scans_.push_back({utime, static_cast<int>(keys_.size()) - 1,
                    since ? since->mark_from_robot : slam_.world_from_robot()});
}

bool LineMapper::key_is_due() const {
  const auto since = slam_.filter().since_mark();
  return !since ||
         since->mark_from_robot.translation_m().norm() >= options_.keyframes.keyframe_distance_m ||
         std::abs(since->mark_from_robot.theta_rad) >=
             deg_to_rad(options_.keyframes.keyframe_turn_deg);
}

void LineMapper::add_key(const ScanInRobot& scan, Utime utime) {
  Keyframe key{utime,
               orient(hits_of(scan), scan.sensor_m, options_.normals,
                      range_sigma_of(hits_of(scan), scan.sensor_m).value_or(0.0)),
               scan.sensor_m,
               0.0,
               slam_.world_from_robot(),
               0.0};
  const int node = graph_.add_node(key.world_from_robot);
  if (const auto since = slam_.filter().since_mark(); since && !keys_.empty()) {
    key.path_m = keys_.back().path_m + since->mark_from_robot.translation_m().norm();
    const Eigen::Matrix3d covariance =
        since->covariance +
        diagonal_covariance(options_.edge_sigma_m, deg_to_rad(options_.edge_sigma_deg));
    // The graph's error lives in the frame of the newer keyframe.
    const Eigen::Matrix3d in_key = rotated(covariance, -since->mark_from_robot.theta_rad);
    graph_.add_edge({node - 1, node, since->mark_from_robot, information_of(in_key), false});
  }
  keys_.push_back(std::move(key));
  key_beams_.push_back(scan);
  slam_.mark_pose();
}

bool LineMapper::close_loops() {
  const double path_m = keys_.back().path_m;
  if (!options_.close_loops || path_m - last_search_path_m_ < options_.loops.attempt_every_m) {
    return false;
  }
  last_search_path_m_ = path_m;
  bool contradicts = false;
  const std::vector<Loop> found =
      loop_closer_.find(keys_, uncertainties_by_path(keys_), closed_path_m_);
  for (const Loop& loop : found) {
    closed_path_m_ = path_m;
    loops_.push_back(loop);
    graph_.add_edge({loop.from, loop.to, loop.from_from_to, loop.information, true});
    contradicts = contradicts || loop.shift_m > options_.trusted_shift_m ||
                  std::abs(loop.turn_deg) > options_.trusted_turn_deg;
  }
  if (!contradicts) return false;
  PoseGraph trial = graph_;
  const PoseGraphResult result = trial.optimize_robustly();
  if (!result.edge_is_inlier.back()) return false;
  graph_ = std::move(trial);
  ++replays_;
  replay();
  return true;
}

// The keyframes' scans once more, each from where the graph says it was taken: the filter starts
// again, and so do the walls. O(keyframes), only when a loop contradicts the filter.
void LineMapper::replay() {
  LineSlam again(options_.lines, graph_.poses().front());
  const Eigen::Matrix3d noise =
      diagonal_covariance(options_.replay_sigma_m, options_.replay_sigma_deg);
  for (std::size_t key = 0; key < keys_.size(); ++key) {
    keys_[key].world_from_robot = graph_.poses()[key];
    const Pose2 motion = between(again.world_from_robot(), graph_.poses()[key]);
    again.process_known(key_beams_[key], motion, key == 0 ? Eigen::Matrix3d::Zero().eval() : noise);
  }
  again.mark_pose();
  slam_ = std::move(again);
  ++revision_;
}

void LineMapper::finish() {
  if (loops_.empty()) return;
  const auto since = slam_.filter().since_mark();
  const PoseGraphResult result = graph_.optimize_robustly();
  for (std::size_t edge = 0, loop = 0; edge < graph_.edges().size(); ++edge) {
    if (graph_.edges()[edge].is_loop) loops_[loop++].is_inlier = result.edge_is_inlier[edge];
  }
  replay();
  if (since) slam_.carry(since->mark_from_robot);
}

Trajectory LineMapper::trajectory() const { return trajectory_of(scans_, keys_); }

std::vector<std::optional<Pose2>> LineMapper::scan_poses() const {
  std::vector<std::optional<Pose2>> poses;
  for (const StampedPose2& pose : trajectory()) poses.emplace_back(pose.world_from_robot);
  return poses;
}

Trajectory LineMapper::key_trajectory() const { return trajectory_of(keys_); }

OccupancyGrid LineMapper::grid() const { return draw_grid(keys_, options_.grid); }

LineMapper::Stored LineMapper::store() {
  return {slam_.store(),       keys_,          key_beams_, graph_.edges(), loops_, scans_,
          last_search_path_m_, closed_path_m_, replays_,   revision_};
}

void LineMapper::restore(const Stored& stored) {
  check(stored);
  slam_.restore(stored.slam);
  graph_ = PoseGraph(options_.graph);
  for (const Keyframe& key : stored.keys) graph_.add_node(key.world_from_robot);
  for (const PoseGraphEdge& edge : stored.edges) graph_.add_edge(edge);
  keys_ = stored.keys;
  key_beams_ = stored.key_beams;
  loops_ = stored.loops;
  scans_ = stored.scans;
  last_search_path_m_ = stored.last_search_path_m;
  closed_path_m_ = stored.closed_path_m;
  replays_ = stored.replays;
  revision_ = stored.revision;
}

}  // namespace marco::slam
