#include "slam/slam.hpp"

#include "lcm_tools/base/check.hpp"
#include "slam/front_end/straightening.hpp"
#include "slam/map/covered_laser.hpp"
#include "slam/map/keyframe_grid.hpp"

namespace marco::slam {
namespace {

// Of an edge between consecutive keyframes, added to the match's own covariance: what a match
// cannot know of itself (motion in the scan, a moving crowd, the local map's own error).
constexpr double kEdgeSigmaM = 0.008;
constexpr double kEdgeSigmaDeg = 0.10;
// No prediction is believed better than this.
constexpr double kPredictionSigmaM = 0.001, kPredictionSigmaRad = 0.001;

Eigen::Matrix3d prediction_covariance() {
  return diagonal_covariance(kPredictionSigmaM, kPredictionSigmaRad);
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
    SlamUpdate update = note_scan(input, {carried_on, predicted.covariance}, false);
    update.covered = predicted.covered;
    return update;
  }
  MatchedScan matched = matched_scan(input, predicted);
  const bool refused = refuse(matched.match, predicted);
  move(matched, predicted);
  SlamUpdate update;
  update.became_key = predicted.is_matched && !refused && becomes_keyframe(input, matched);
  if (update.became_key) {
    add_keyframe(input, matched.points, predicted.guess.source);
    update.trajectory_changed = search_loops();
    cull_keyframes();
  }
  const SlamUpdate noted = note_scan(input, estimate_, matched.match.usable);
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

Slam::Prediction Slam::predict(const SlamInput& input) {
  const Eigen::Index returns = input.level ? input.scan.hits_in_robot.cols() : 0;
  const bool has_points = returns >= options_.gates.min_points;
  Prediction predicted;
  predicted.motion = input.motion;
  predicted.motion.first_from_middle = first_from_middle(input.scan);
  predicted.guess = motion_.guess(predicted.motion, has_points);
  const MotionGuess& guess = predicted.guess;
  const PoseWithCovariance now = dead_reckoned(estimate_, guess.before_from_now, guess.covariance);
  predicted.covariance = now.covariance + prediction_covariance();
  predicted.prior = {now.world_from_robot, information_of(predicted.covariance)};
  if (has_points) {
    const Pose2 places[] = {now.world_from_robot, estimate_.world_from_robot};
    covered_ = laser_is_covered(input.scan.hits_in_robot, input.scan.sensor_in_robot, places,
                                keyframes_.keys, covered_);
    predicted.covered = covered_;
  }
  // Few returns refine the odometry's pose, and do not judge the odometry.
  predicted.refines = !has_points && guess.source == MotionGuess::Source::odometry &&
                      returns >= match_gates::kFewestPoints;
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
void Slam::move(const MatchedScan& matched, const Prediction& predicted) {
  const ScanMatch& match = matched.match;
  const MotionGuess& guess = predicted.guess;
  const Pose2 before = estimate_.world_from_robot;
  const Eigen::Matrix3d since_keyframe =
      dead_reckoned({before, since_keyframe_}, guess.before_from_now, guess.covariance).covariance +
      prediction_covariance();
  since_keyframe_ =
      covariance_of(information_of(since_keyframe) + match.information) + matched.doubt;
  const bool stands = motion_.stands_still(predicted.motion, match.information);
  estimate_ = estimate_from(match, predicted.prior, stands);
  const Pose2& now = estimate_.world_from_robot;
  motion_.update(predicted.motion, between(before, now), match.usable && !predicted.refines,
                 rotated(covariance_of(match.information), -before.theta_rad));
  if (match.usable) {
    path_.spread_correction(predicted.prior.map_from_robot, now, keyframes_.keys);
  }
}

bool Slam::becomes_keyframe(const SlamInput& input, const MatchedScan& matched) const {
  return gate_.may_draw() && input.may_draw &&
         (!matched.doubt.isZero() ||  // it belongs to this step alone
          keyframes_.is_due(estimate_.world_from_robot, input.scan.sensor_heading_rad,
                            options_.keyframes));
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
                                       const PosePrior& prior,
                                       bool stands) {
  PoseWithCovariance estimate{match.world_from_robot};
  // Until there is a map, the place is where the map begins.
  if (!keyframes_.keys.empty()) {
    estimate.covariance = covariance_of(prior.information + match.information);
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
                        MotionGuess::Source source) {
  Keyframe key{input.scan.utime,           points,
               input.scan.sensor_in_robot, input.scan.sensor_heading_rad,
               estimate_.world_from_robot, 0.0};
  const auto node = static_cast<int>(keyframes_.keys.size());
  if (node > 0) {
    const Keyframe& before = keyframes_.keys.back();
    const Pose2 measured = between(before.world_from_robot, key.world_from_robot);
    key.path_m = before.path_m + measured.translation_m().norm();
    const Eigen::Matrix3d covariance =
        rotated(since_keyframe_, -before.world_from_robot.theta_rad) +
        diagonal_covariance(kEdgeSigmaM, deg_to_rad(kEdgeSigmaDeg));
    // The graph's error lives in the frame of the newer keyframe.
    back_end_.add_edge({node - 1, node, measured,
                        information_of(rotated(covariance, -measured.theta_rad)), false});
  }
  // Odometry's errors are new at each step; those of a velocity that is carried on are not, and add
  // up.
  if (source == MotionGuess::Source::odometry) since_keyframe_.setZero();
  path_.add_keyframe(key.utime, node);
  keyframes_.keys.push_back(std::move(key));
  local_map_.extend(keyframes_);
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
  const Pose2 key_from_robot = between(keys.back().world_from_robot, estimate_.world_from_robot);
  path_.spread_moves(keys, world_from_keys);
  for (std::size_t key = 0; key < keys.size(); ++key) {
    keys[key].world_from_robot = world_from_keys[key];
  }
  estimate_.world_from_robot = keys.back().world_from_robot * key_from_robot;
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
  SlamState state{keyframes_, path_.state(),   back_end_.state(), culling_.state(),
                  noise_,     motion_.state(), estimate_,         since_keyframe_,
                  {},         gate_.state(),   covered_,          local_map_.centre_m(),
                  revision_};
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
  since_keyframe_ = state.since_keyframe;
  standing_.reset();
  if (state.zero_velocity) standing_.emplace(*state.zero_velocity);
  gate_.restore(state.gate);
  covered_ = state.covered;
  local_map_.restore(keyframes_, state.local_map_centre_m);
  revision_ = state.revision;
}

}  // namespace marco::slam
