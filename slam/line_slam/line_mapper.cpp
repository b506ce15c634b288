#include "slam/line_slam/line_mapper.hpp"

#include <cmath>

#include "common/covariance.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// The filter is replayed along all keyframes.
SlamOptions without_culling(SlamOptions options) {
  options.culling.after_keyframes = 1000000;
  return options;
}

SlamState state_at(const Pose2& world_from_robot) {
  SlamState state;
  state.estimate.world_from_robot = world_from_robot;
  check(state);
  return state;
}

}  // namespace

LineMapper::LineMapper(const LineMapperOptions& options, const Pose2& world_from_robot)
    : options_(options),
      slam_(without_culling(options.slam)),
      lines_(options.lines, world_from_robot),
      slam_pose_(world_from_robot) {
  validate(options, "line_mapper");
  slam_.defer_loop_work();
  slam_.restore(state_at(world_from_robot));
}

LineSlamUpdate LineMapper::process(const SlamInput& input,
                                   const ScanInRobot& scan,
                                   LineSlamJournal* journal) {
  const bool first = keys().empty();
  const SlamUpdate matched = slam_.process(input);
  const Pose2 motion = between(slam_pose_, matched.world_from_robot);
  slam_pose_ = matched.world_from_robot;
  const bool guessed =
      matched.status == SlamUpdate::Status::predicted && !first && !input.motion.odom_from_robot;
  if (guessed) lines_.doubt();
  LineSlamUpdate update =
      input.level
          ? lines_.process(scan, motion, input.may_draw ? MapUse::draw : MapUse::pose_only, journal)
          : lines_.carry(motion);
  if (matched.became_key) key_beams_.push_back(scan);
  update.trajectory_changed = close_loops();
  update.world_from_robot = lines_.world_from_robot();
  update.covariance = filter().robot_covariance();
  return update;
}

bool LineMapper::close_loops() {
  std::optional<LoopWork> work;
  if (options_.close_loops) work = slam_.take_loop_work();
  if (!work) return false;
  work->run();
  const Pose2 key_from_robot = between(keys().back().world_from_robot, slam_pose_);
  if (!slam_.accept(*work)) return false;
  slam_pose_ = keys().back().world_from_robot * key_from_robot;
  if (!is_trusted()) {
    ++replays_;
    replay();
  }
  return true;
}

bool LineMapper::is_trusted() const {
  const Pose2 off = between(slam_pose_, world_from_robot());
  return off.translation_m().norm() <= options_.trusted_shift_m &&
         std::abs(off.theta_rad) <= deg_to_rad(options_.trusted_turn_deg);
}

// The keyframes' scans once more, each from where the graph says it was taken: the filter starts
// again, and so do the walls. Each pose is believed by itself: as a chain of motions they would
// leave later scans no say against the first ones. O(keyframes).
void LineMapper::replay() {
  LineSlam again(options_.lines, keys().front().world_from_robot);
  const Eigen::Matrix3d covariance =
      diagonal_covariance(options_.replay_sigma_m, deg_to_rad(options_.replay_sigma_deg));
  std::vector<Pose2> seen_from;
  for (std::size_t key = 0; key < keys().size(); ++key) {
    again.process_at(key_beams_[key], keys()[key].world_from_robot, covariance);
    seen_from.push_back(again.world_from_robot());
  }
  again.judge_again(key_beams_, seen_from);
  again.carry(between(keys().back().world_from_robot, slam_pose_));
  lines_ = std::move(again);
}

void LineMapper::finish() {
  if (keys().empty()) return;
  const Pose2 key_from_robot = between(keys().back().world_from_robot, slam_pose_);
  if (options_.close_loops) slam_.finish();
  slam_pose_ = keys().back().world_from_robot * key_from_robot;
  replay();
}

std::vector<std::optional<Pose2>> LineMapper::scan_poses() const {
  std::vector<std::optional<Pose2>> poses;
  for (const StampedPose2& pose : trajectory()) poses.emplace_back(pose.world_from_robot);
  return poses;
}

LineMapper::Stored LineMapper::store() const {
  return {lines_.store(), slam_.state(), key_beams_, slam_pose_, replays_};
}

void LineMapper::restore(const Stored& stored) {
  check(stored.slam);
  require(stored.key_beams.size() == stored.slam.keyframes.keys.size(),
          "line_mapper: beams are not of each keyframe");
  lines_.restore(stored.lines);
  slam_.restore(stored.slam);
  key_beams_ = stored.key_beams;
  slam_pose_ = stored.slam_pose;
  replays_ = stored.replays;
}

}  // namespace marco::slam
