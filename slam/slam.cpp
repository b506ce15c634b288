#include "slam/slam.hpp"

#include <algorithm>

#include "lcm_tools/base/check.hpp"
#include "slam/front_end/straightening.hpp"
#include "slam/map/covered_laser.hpp"
#include "slam/map/keyframe_grid.hpp"

namespace marco::slam {
namespace {

// Of a match, added to its own covariance where it makes an edge between consecutive keyframes:
// what it cannot know of itself (motion in the scan, a moving crowd, the local map's own error).
constexpr double kEdgeSigmaM = 0.008;
constexpr double kEdgeSigmaDeg = 0.10;
// No prediction is believed better than this.
constexpr double kPredictionSigmaM = 0.001, kPredictionSigmaRad = 0.001;

Eigen::Matrix3d prediction_information(const Eigen::Matrix3d& covariance) {
  return information_of(covariance + diagonal_covariance(kPredictionSigmaM, kPredictionSigmaRad));
}

// Keyframes examined for each new one, so that no scan waits for many.
constexpr int kCulledAtOnce = 3;

}  // namespace

Slam::Slam(const SlamOptions& options)
    : options_(options),
      matcher_(options.gates, options.fine, options.coarse),
      motion_(options.motion),
      local_map_(options.local_map, options.fine, options.coarse),
      culling_(options.culling),
      back_end_(
          {options.loops, matcher_.coarse(), matcher_.fine()}, options.graph, options.refinement) {
  validate(options, "slam");
}

SlamUpdate Slam::process(const SlamInput& input) {
  Prediction predicted = predict(input);
  // Odometry will give the whole way since the last scan that was matched: its uncertainty does not
  // add up over the scans of a sweep.
  if (!predicted.is_matched && predicted.guess.source == MotionGuess::Source::odometry) {
    const Pose2& carried_on = predicted.prior.map_from_robot;
    SlamUpdate update = note_scan(
        input, {carried_on, predicted.in_world.covariance + predicted.scale.covariance()}, false);
    update.covered = predicted.covered;
    return update;
  }
  MatchedScan matched = matched_scan(input, predicted);
  const bool refused = refuse(matched.match, predicted);
  const Eigen::Matrix3d edge_covariance = move(matched, predicted);
  SlamUpdate update;
  update.became_key = predicted.is_matched && !refused && becomes_keyframe(input);
  if (update.became_key) {
    add_keyframe(input, matched.points, edge_covariance);
    update.trajectory_changed = search_loops();
    cull_keyframes();
  }
  const SlamUpdate noted =
      note_scan(input, {estimate_.world_from_robot, estimate_.covariance + scale_.covariance()},
                matched.match.usable);
  const bool edited = add_edited_loops();
  update.world_from_robot = edited ? estimate_.world_from_robot : noted.world_from_robot;
  update.covariance = noted.covariance;
  update.trajectory_changed |= edited;
  if (matched.match.usable) update.status = SlamUpdate::Status::matched;
  update.overlap = matched.match.overlap;
  update.covered = predicted.covered;
  update.misfits_m2 = std::move(matched.misfits_m2);
  return update;
}

PosePrior Slam::prior_of(const PoseWithCovariance& predicted) {
  return {predicted.world_from_robot, prediction_information(predicted.covariance),
          match_gates::kPriorFreedom};
}

Slam::Prediction Slam::predict(const SlamInput& input) {
  const Eigen::Index returns = input.level ? input.scan.hits_in_robot.cols() : 0;
  const bool has_points = returns >= options_.gates.min_points;
  Prediction predicted;
  predicted.motion = input.motion;
  predicted.motion.first_from_middle = first_from_middle(input.scan);
  predicted.guess = motion_.guess(predicted.motion, has_points);
  predicted.carried = drift_.carried(predicted.guess);
  PoseWithCovariance now = predicted.carried.drifted;
  now.covariance += predicted.carried.jitter;
  predicted.prior = prior_of(now);
  predicted.in_world =
      dead_reckoned(estimate_, predicted.guess.before_from_now, predicted.guess.drift);
  predicted.scale = scale_;
  if (predicted.carried.by_odometry) {
    predicted.scale.carry(estimate_.world_from_robot, now.world_from_robot);
  }
  if (has_points) {
    const Pose2 places[] = {now.world_from_robot, estimate_.world_from_robot};
    covered_ = laser_is_covered(input.scan.hits_in_robot, input.scan.sensor_in_robot, places,
                                keyframes_.keys, covered_);
    predicted.covered = covered_;
  }
  // Few returns refine the odometry's pose, and do not judge the odometry.
  predicted.refines =
      !has_points && predicted.carried.by_odometry && returns >= match_gates::kFewestPoints;
  predicted.is_matched = (has_points && !predicted.covered) || predicted.refines;
  return predicted;
}

MatchedScan Slam::matched_scan(const SlamInput& input, Prediction& predicted) {
  if (!predicted.is_matched) return {{}, {}, {predicted.prior.map_from_robot}, {}};
  MatchedScan matched = matched_scan(input, predicted.prior, predicted.guess.source);
  predicted.motion.first_from_middle = first_from_middle(matched.scan);
  return matched;
}

/// Replaces a match that the gate refuses by the prediction.
bool Slam::refuse(ScanMatch& match, const Prediction& predicted) {
  const Pose2& before = estimate_.world_from_robot;
  const bool refused = gate_.refuses(match, before, motion_, predicted.motion.utime);
  if (refused) {
    match = {predicted.prior.map_from_robot, Eigen::Matrix3d::Zero(), match.overlap, false};
  } else if (predicted.is_matched) {
    gate_.note_match(match.usable || keyframes_.keys.empty());
  }
  return refused;
}

/// To where the match, the prediction and, of a robot that stands, the matches before say.
Eigen::Matrix3d Slam::move(const MatchedScan& matched, const Prediction& predicted) {
  const ScanMatch& match = matched.match;
  const Pose2 before = estimate_.world_from_robot;
  const Pose2 carried_from = drift_.state().drifted.world_from_robot;
  const PosePrior& prior = predicted.prior;
  const double weight =
      std::min(1.0, prior.weight(difference(match.world_from_robot, prior.map_from_robot)));
  const bool stands = motion_.stands_still(predicted.motion, match.information);
  const Eigen::Matrix3d predicted_information =
      weight * prediction_information(predicted.in_world.covariance);
  estimate_ = estimate_from(match, predicted_information, stands);
  scale_ = predicted.scale;
  scale_.correct(estimate_.covariance * predicted_information);
  const Pose2& now = estimate_.world_from_robot;
  if (!keyframes_.keys.empty() && match.usable) {
    // Neither few returns nor a robot that stands tell how a reading errs.
    const bool judges_jitter = !predicted.refines && !stands;
    drift_.correct(predicted.carried, {now, match.information, weight, judges_jitter},
                   motion_.odometry_noise());
  } else {
    drift_.follow(predicted.carried);
  }
  motion_.update(predicted.motion, between(before, now), match.usable && !predicted.refines,
                 rotated(covariance_of(match.information), -before.theta_rad));
  if (match.usable) {
    path_.spread_correction(carried_from, predicted.prior.map_from_robot, now, keyframes_.keys);
  }
  const Eigen::Matrix3d unknown = diagonal_covariance(kEdgeSigmaM, deg_to_rad(kEdgeSigmaDeg));
  return covariance_of(weight * prediction_information(predicted.carried.since_keyframe) +
                       with_noise(match.information, unknown));
}

bool Slam::becomes_keyframe(const SlamInput& input) const {
  return gate_.may_draw() && input.may_draw &&
         keyframes_.is_due(estimate_.world_from_robot, input.scan.sensor_heading_rad,
                           options_.keyframes);
}

SlamUpdate Slam::note_scan(const SlamInput& input,
                           const PoseWithCovariance& estimate,
                           bool matched) {
  const auto odom_from_robot =
      motion_.trusts_odometry() ? input.motion.odom_from_robot : std::nullopt;
  path_.add_scan({input.scan.utime, estimate.world_from_robot}, odom_from_robot, !matched,
                 keyframes_.keys);
  SlamUpdate update;
  update.world_from_robot = estimate.world_from_robot;
  update.covariance = estimate.covariance;
  return update;
}

PoseWithCovariance Slam::estimate_from(const ScanMatch& match,
                                       const Eigen::Matrix3d& information,
                                       bool stands) {
  PoseWithCovariance estimate{match.world_from_robot};
  // Until there is a map, the place is where the map begins.
  if (!keyframes_.keys.empty()) {
    estimate.covariance = covariance_of(information + match.information);
  }
  if (!match.usable || !stands) {
    standing_.reset();
    return estimate;
  }
  if (!standing_) standing_.emplace(estimate_.covariance);
  const Pose2& before = estimate_.world_from_robot;
  const auto correction = standing_->update(difference(match.world_from_robot, before),
                                            covariance_of(match.information));
  if (!correction) {  // wheels may stand still while the robot is pushed
    standing_.reset();
    return estimate;
  }
  const Eigen::Vector3d& step = correction->step;
  return {
      {before.x_m + step.x(), before.y_m + step.y(), normalize_angle(before.theta_rad + step.z())},
      correction->covariance};
}

void Slam::add_keyframe(const SlamInput& input,
                        const OrientedPoints& points,
                        const Eigen::Matrix3d& edge_covariance) {
  Keyframe key{input.scan.utime,           points,
               input.scan.sensor_in_robot, input.scan.sensor_heading_rad,
               estimate_.world_from_robot, 0.0};
  const auto node = static_cast<int>(keyframes_.keys.size());
  if (node > 0) {
    const Keyframe& before = keyframes_.keys.back();
    const Pose2 measured = between(before.world_from_robot, key.world_from_robot);
    key.path_m = before.path_m + measured.translation_m().norm();
    const Eigen::Matrix3d covariance = rotated(edge_covariance, -before.world_from_robot.theta_rad);
    // The graph's error lives in the frame of the newer keyframe.
    back_end_.add_edge({node - 1, node, measured,
                        information_of(rotated(covariance, -measured.theta_rad)), false});
  }
  path_.add_keyframe(key.utime, node);
  keyframes_.keys.push_back(std::move(key));
  drift_.begin_at_keyframe(local_map_.extend(keyframes_), motion_.odometry_noise());
}

bool Slam::search_loops() {
  if (!back_end_.prepare_work(keyframes_.keys, culling_.is_due(keyframes_.keys.size())) ||
      back_end_.is_deferred()) {
    return false;
  }
  std::optional<LoopWork> work = back_end_.take_work();
  work->run();
  return accept(*work);
}

void Slam::set_edits(const MapEdits& edits) {
  back_end_.set_edits(edits);
  edited_loops_.set(edits);
}

void Slam::apply(const MapEdits& edits) {
  back_end_.remove_loops(edits, keyframes_.keys);
  EditedLoops added;
  added.set(edits);
  for (const PoseGraphEdge& edge : added.take_due(path_.state().scans)) back_end_.add_edge(edge);
}

bool Slam::add_edited_loops() {
  const std::vector<PoseGraphEdge> edges = edited_loops_.take_due(path_.state().scans);
  for (const PoseGraphEdge& edge : edges) back_end_.add_edge(edge);
  if (!edges.empty()) move_keyframes(back_end_.optimized(keyframes_.keys));
  return !edges.empty();
}

bool Slam::accept(const LoopWork& work) {
  const std::optional<std::vector<Pose2>> moved = back_end_.accept(work, keyframes_.keys);
  if (!moved) return false;
  if (work.robust) culling_.begin_round(static_cast<int>(work.graph.node_count()));
  move_keyframes(*moved);
  return true;
}

void Slam::cull_keyframes() {
  if (back_end_.is_busy()) return;
  for (int i = 0; i < kCulledAtOnce && culling_.is_pending(); ++i) {
    const int key = culling_.next();
    const bool loop_closed =
        back_end_.has_loops_around(keyframes_.keys[static_cast<std::size_t>(key)].path_m);
    const auto merged = culling_.step(keyframes_.keys, loop_closed, matcher_.fine());
    if (merged) merge_keyframe(key, *merged);
  }
}

void Slam::merge_keyframe(int key, const MergedKeyframe& merged) {
  back_end_.merge_node(key, merged);
  path_.reattach_to_keyframe(key, merged, keyframes_.keys);
  keyframes_.keys.erase(keyframes_.keys.begin() + key);
  ++keyframes_.merged;
  local_map_.drop_likelihood();
  path_.shorten(keyframes_.keys);
}

void Slam::move_keyframes(const std::vector<Pose2>& world_from_keys) {
  std::vector<Keyframe>& keys = keyframes_.keys;
  const Pose2 before = estimate_.world_from_robot;
  const Pose2 key_from_robot = between(keys.back().world_from_robot, before);
  path_.spread_moves(keys, world_from_keys);
  for (std::size_t key = 0; key < keys.size(); ++key) {
    keys[key].world_from_robot = world_from_keys[key];
  }
  estimate_.world_from_robot = keys.back().world_from_robot * key_from_robot;
  drift_.move_with_map(before, estimate_.world_from_robot);
  ++revision_;
  standing_.reset();
  local_map_.rebuild(keyframes_);
}

JointRefinementResult Slam::finish() {
  JointRefinementResult result;
  if (keyframes_.keys.size() >= 2) move_keyframes(back_end_.finish(keyframes_.keys, result));
  return result;
}

OccupancyGrid Slam::grid() const { return draw_grid(keyframes_.keys, options_.grid); }

SlamState Slam::state() const {
  SlamState state{keyframes_,      path_.state(), back_end_.state(),     culling_.state(), noise_,
                  motion_.state(), estimate_,     drift_.state(),        scale_,           {},
                  gate_.state(),   covered_,      local_map_.centre_m(), revision_};
  if (standing_) state.zero_velocity = standing_->state();
  return state;
}

void Slam::restore(const SlamState& state) {
  check(state);
  keyframes_ = state.keyframes;
  path_.restore(state.path);
  back_end_.restore(state.back_end);
  culling_.restore(state.culling);
  noise_ = state.noise;
  motion_.restore(state.motion);
  estimate_ = state.estimate;
  drift_.restore(state.drift.value_or(CarriedPose::at(state.estimate)));
  scale_ = state.scale;
  standing_.reset();
  if (state.zero_velocity) standing_.emplace(*state.zero_velocity);
  gate_.restore(state.gate);
  covered_ = state.covered;
  local_map_.restore(keyframes_, state.local_map_centre_m);
  revision_ = state.revision;
}

}  // namespace marco::slam
