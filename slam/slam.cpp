#include "slam/slam.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "slam/map/keyframe_grid.hpp"

namespace marco::slam {
namespace {

// Of an edge between consecutive keyframes, added to the match's own covariance: what a match
// cannot know of itself (motion in the scan, a moving crowd, the local map's own error).
constexpr double kEdgeSigmaM = 0.008;
constexpr double kEdgeSigmaDeg = 0.10;

// By how much more of the points another match must explain to be taken instead.
constexpr double kClearlyBetter = 0.05;

// The same where odometry must have lied for it.
constexpr double kProvesLie = 0.10;

// What is left of the information of odometry that the scan contradicts.
constexpr double kDoubtedPrior = 0.01;

// A scan that fits nothing is drawn only after so many: odometry that leapt has placed it, and what
// is drawn there makes the next ones fit.
constexpr int kUnmatchedUntilDrawn = 3;

// A match that leaps from where odometry says, as no robot can, is believed when all do for so
// long: another robot's scans may come between ours, and they fit where that one is.
constexpr double kLeapsUntilBelievedS = 1.0;

// What the scan alone is looked for within, where odometry is contradicted.
constexpr double kWidestM = 1.5, kWidestDeg = 45.0;

// Squared deviations (of 3 degrees of freedom; 1 of 900 honest ones is beyond) from which on one
// measurement contradicts another.
constexpr double kContradiction = 16.0;

Eigen::Vector3d off(const Pose2& pose, const Pose2& from) {
  return {pose.x_m - from.x_m, pose.y_m - from.y_m,
          normalize_angle(pose.theta_rad - from.theta_rad)};
}

// Jacobian of a pose a*b by b: b's covariance is given in the frame of a.
Eigen::Matrix3d turned_into(const Eigen::Matrix3d& covariance, double theta_rad) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Pose2{0, 0, theta_rad}.rotation();
  return turn * covariance * turn.transpose();
}

Eigen::Matrix3d inverse_of(const Eigen::Matrix3d& information) {
  return (information + 1e-6 * Eigen::Matrix3d::Identity()).inverse();
}

SearchWindow window_of(const PosePrior& prior) {
  const Eigen::Matrix3d covariance = inverse_of(prior.information);
  const double sigma_m = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  const double sigma_rad = std::sqrt(covariance(2, 2));
  return {prior.map_from_robot, std::clamp(3.0 * sigma_m, 0.3, kWidestM),
          std::clamp(3.0 * sigma_rad, deg_to_rad(5.0), deg_to_rad(kWidestDeg))};
}

}  // namespace

Slam::Slam(const SlamOptions& options)
    : options_(options),
      matcher_(options.fine),
      coarse_(options.coarse),
      loop_closer_(options.loops, coarse_, matcher_),
      motion_(options.motion),
      graph_(options.graph) {
  validate(options, "slam");
}

SlamUpdate Slam::process(const SlamInput& input) {
  const MotionGuess guess = motion_.guess(input.motion);
  const bool enough = input.scan.hits_in_robot.cols() >= options_.min_points;
  const bool use = input.level && enough;
  const OrientedPoints points =
      use ? orient(input.scan.hits_in_robot, input.scan.sensor_in_robot, options_.normals)
          : OrientedPoints{};
  const PosePrior prior = prior_of(guess);
  // Odometry is asked anew for the whole way since the last scan that was looked at: its
  // uncertainty does not add up over the scans of a sweep.
  if (!use && guess.source == MotionGuess::Source::odometry) {
    return note_scan(input.scan.utime, prior.map_from_robot, inverse_of(prior.information));
  }
  Match found;
  found.world_from_robot = prior.map_from_robot;
  if (use && local_map_) found = match(points, guess, prior);
  const bool doubted = found.usable && doubt_leap(found, prior, input.scan.utime);
  // Until there is a map, the place is where the map begins.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (!keys_.empty()) covariance = inverse_of(prior.information + found.information);
  if (found.usable && motion_.stands_still(input.motion)) {
    look_again(found, covariance);
  } else {
    standing_.reset();
  }
  motion_.update(input.motion, between(world_from_robot_, found.world_from_robot));
  covariance_ = covariance;
  world_from_robot_ = found.world_from_robot;
  bool became_key = false, trajectory_changed = false;
  if (use && !doubted) {
    unmatched_ = found.usable || keys_.empty() ? 0 : std::min(unmatched_ + 1, kUnmatchedUntilDrawn);
  }
  const bool fits = unmatched_ == 0 || unmatched_ >= kUnmatchedUntilDrawn;
  if (use && fits && !doubted && input.may_draw && key_is_due(input.scan, world_from_robot_)) {
    add_key(input, points, found);
    became_key = true;
    trajectory_changed = look_for_loops();
    thin_keys();
  }
  SlamUpdate update = note_scan(input.scan.utime, world_from_robot_, covariance_);
  if (found.usable) update.status = SlamUpdate::Status::matched;
  update.overlap = found.overlap;
  update.became_key = became_key;
  update.trajectory_changed = trajectory_changed;
  return update;
}

bool Slam::doubt_leap(Match& found, const PosePrior& prior, Utime utime) {
  const bool leaps =
      motion_.leaps(between(world_from_robot_, found.world_from_robot), utime) &&
      motion_.leaps(between(prior.map_from_robot, found.world_from_robot), motion_.newest());
  if (leaps && !leaps_since_) leaps_since_ = utime;
  if (!leaps || std::abs((utime - *leaps_since_).seconds()) >= kLeapsUntilBelievedS) {
    leaps_since_.reset();
    return false;
  }
  found = {prior.map_from_robot, Eigen::Matrix3d::Zero(), found.overlap, false};
  return true;
}

SlamUpdate Slam::note_scan(Utime utime,
                           const Pose2& world_from_robot,
                           const Eigen::Matrix3d& covariance) {
  const int key = static_cast<int>(keys_.size()) - 1;
  const Pose2 key_from_robot =
      keys_.empty() ? world_from_robot : between(keys_.back().world_from_robot, world_from_robot);
  const ScanPose scan{utime, key, key_from_robot};
  if (is_worth_keeping(scan)) scans_.push_back(scan);
  SlamUpdate update;
  update.world_from_robot = world_from_robot;
  update.covariance = covariance;
  return update;
}

PosePrior Slam::prior_of(const MotionGuess& guess) const {
  // What is not known of the pose before, the move's own uncertainty, and how a wrong heading there
  // carries the move aside.
  const Pose2 prediction = world_from_robot_ * guess.before_from_now;
  Eigen::Matrix3d carry = Eigen::Matrix3d::Identity();
  carry(0, 2) = -(prediction.y_m - world_from_robot_.y_m);
  carry(1, 2) = prediction.x_m - world_from_robot_.x_m;
  const Eigen::Matrix3d covariance = carry * covariance_ * carry.transpose() +
                                     turned_into(guess.covariance, world_from_robot_.theta_rad);
  return {prediction, inverse_of(covariance)};
}

Slam::Match Slam::match(const OrientedPoints& points,
                        const MotionGuess& guess,
                        const PosePrior& prior) {
  SurfelMatch fine = matcher_.match(*local_map_, points, prior.map_from_robot, &prior);
  if (fine.overlap < options_.sure_overlap && guess.source == MotionGuess::Source::odometry) {
    // Wheels may have slipped: the scan alone, hardly held by odometry.
    const PosePrior weak{prior.map_from_robot, kDoubtedPrior * prior.information};
    const SurfelMatch free = matcher_.match(*local_map_, points, prior.map_from_robot, &weak);
    const Eigen::Vector3d denied = off(free.map_from_robot, prior.map_from_robot);
    if (free.overlap > fine.overlap + kProvesLie &&
        denied.dot(prior.information * denied) > kContradiction) {
      fine = free;
    }
  }
  Match result{
      fine.map_from_robot, fine.information, fine.overlap,
      fine.status != SurfelMatch::Status::no_overlap && fine.overlap >= options_.poor_overlap};
  if (fine.overlap >= options_.good_overlap && guess.source == MotionGuess::Source::odometry) {
    return result;
  }
  const Match wide = match_widely(points, window_of(prior), prior);
  if (wide.usable && wide.overlap > result.overlap + kClearlyBetter) return wide;
  if (result.usable) return result;
  const PosePrior weak{prior.map_from_robot, kDoubtedPrior * prior.information};
  const SearchWindow widest{prior.map_from_robot, kWidestM, deg_to_rad(kWidestDeg)};
  const Match alone = match_widely(points, widest, weak);
  if (alone.usable && alone.overlap >= options_.good_overlap) return alone;
  result.world_from_robot = prior.map_from_robot;
  result.information.setZero();
  return result;
}

void Slam::look_again(Match& match, Eigen::Matrix3d& covariance) {
  if (!standing_) standing_.emplace(covariance_);
  const auto look = standing_->look(off(match.world_from_robot, world_from_robot_),
                                    inverse_of(match.information));
  // Wheels may be still while the robot is pushed.
  if (!look) return standing_.reset();
  match.world_from_robot = {world_from_robot_.x_m + look->step.x(),
                            world_from_robot_.y_m + look->step.y(),
                            normalize_angle(world_from_robot_.theta_rad + look->step.z())};
  covariance = look->covariance;
}

Slam::Match Slam::match_widely(const OrientedPoints& points,
                               const SearchWindow& window,
                               const PosePrior& prior) {
  Match result;
  const CorrelativeMatch coarse = coarse_.search(likelihood_here(), points.points, window, 0.2);
  if (coarse.score <= 0.0) return result;
  const SurfelMatch fine = matcher_.match(*local_map_, points, coarse.map_from_robot, &prior);
  return {fine.map_from_robot, fine.information, fine.overlap,
          fine.status != SurfelMatch::Status::no_overlap && fine.overlap >= options_.poor_overlap};
}

const LikelihoodPyramid& Slam::likelihood_here() {
  if (likelihood_) return *likelihood_;
  const int last = static_cast<int>(keys_.size()) - 1;
  const int first = std::max(0, last - options_.window_keyframes + 1);
  const OrientedPoints map = join_points(keys_, first, last, Pose2{});
  const Eigen::Vector2d centre_m = keys_.back().world_from_robot.translation_m();
  return likelihood_.emplace(points_within(kSearchReachM, centre_m, map.points), coarse_.options());
}

bool Slam::key_is_due(const DeskewedScan& scan, const Pose2& world_from_robot) const {
  const double turn_rad = deg_to_rad(options_.key_turn_deg);
  // Several lasers, or one that pans, look several ways from one place.
  for (auto key = keys_.rbegin(); key != keys_.rend(); ++key) {
    const Pose2 moved = between(key->world_from_robot, world_from_robot);
    if (moved.translation_m().norm() >= options_.key_distance_m ||
        std::abs(moved.theta_rad) >= turn_rad) {
      return true;
    }
    const double panned_rad = normalize_angle(scan.sensor_heading_rad - key->sensor_heading_rad);
    if (std::abs(panned_rad) < turn_rad) return false;
  }
  return true;
}

void Slam::add_key(const SlamInput& input, const OrientedPoints& points, const Match& match) {
  Keyframe key{input.scan.utime,           points,
               input.scan.sensor_in_robot, input.scan.sensor_heading_rad,
               match.world_from_robot,     0.0};
  const int node = graph_.add_node(key.world_from_robot);
  if (!keys_.empty()) {
    const Keyframe& before = keys_.back();
    const Pose2 measured = between(before.world_from_robot, key.world_from_robot);
    key.path_m = before.path_m + measured.translation_m().norm();
    // In the frame of the keyframe before; the match's own floor is what it cannot know of itself.
    Eigen::Matrix3d covariance = turned_into(covariance_, -before.world_from_robot.theta_rad);
    covariance(0, 0) += kEdgeSigmaM * kEdgeSigmaM;
    covariance(1, 1) += kEdgeSigmaM * kEdgeSigmaM;
    covariance(2, 2) += std::pow(deg_to_rad(kEdgeSigmaDeg), 2);
    // The graph's error lives in the frame of the newer keyframe.
    const Eigen::Matrix3d in_key = turned_into(covariance, -measured.theta_rad);
    graph_.add_edge({node - 1, node, measured, in_key.inverse(), false});
  }
  trail_.push_back({key.utime, node, Pose2{}});
  keys_.push_back(std::move(key));
  extend_local_map();
}

Trajectory Slam::trajectory() const { return trajectory_of(scans_, keys_); }

Trajectory Slam::key_trajectory() const { return trajectory_of(trail_, keys_); }

OccupancyGrid Slam::grid() const { return draw_grid(keys_, options_.grid); }

}  // namespace marco::slam
