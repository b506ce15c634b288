#include "slam/localization/localizer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kSearchHalfWidthM = 0.6;
constexpr double kSearchHalfTurnDeg = 20.0;
constexpr double kSearchMinScore = 0.3;

// Of a move that scans saw, beside its own length and turn.
constexpr double kSeenPart = 0.02;
constexpr double kSeenSigmaM = 5e-4;
constexpr double kSeenSigmaDeg = 0.01;

// Keyframes of a session that only says how the robot moves, before it begins anew.
constexpr std::size_t kSessionKeys = 150;

// Part of the points on walls of the map from which on a match says something, as long as it goes
// where the robot's own path does: squared deviations of 3 degrees of freedom.
constexpr double kSomeOverlap = 0.15;
constexpr double kSurprise = 16.0;

// A scan confirms its place by so many of its beams, when hardly any of the others contradicts.
constexpr double kExplained = 0.3;
constexpr double kHardly = 0.1;

Eigen::Matrix3d inverse_of(const Eigen::Matrix3d& matrix) {
  return (matrix + 1e-9 * Eigen::Matrix3d::Identity()).inverse();
}

Beams beams_of(const OrientedPoints& points, const Eigen::Vector2d& sensor_in_robot) {
  Beams beams{points.points, sensor_in_robot.replicate(1, points.points.cols()), {}};
  for (Eigen::Index i = 0; i < points.points.cols(); ++i) {
    beams.clear_m.push_back(
        clear_length_m(points.points.col(i) - sensor_in_robot, points.normals.col(i)));
  }
  return beams;
}

}  // namespace

Localizer::Localizer(std::vector<Keyframe> map,
                     const LocalizerOptions& options,
                     const SlamOptions& slam)
    : options_(options),
      slam_options_(slam),
      map_(std::make_unique<FrozenMap>(std::move(map), options, slam)),
      coarse_(slam.coarse),
      finder_(*map_, options),
      session_(slam),
      motion_(slam.motion),
      map_from_sessions_(1) {}

void Localizer::forget_place() {
  tracking_ = false;
  session_ = Slam(slam_options_);
  finder_.restart();
  map_from_sessions_.emplace_back();
}

void Localizer::set_pose(const Pose2& map_from_robot) {
  require(is_finite(map_from_robot), "localizer: the pose is not finite");
  forget_place();
  motion_ = MotionModel(slam_options_.motion);
  begin_tracking(map_from_robot, Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal());
}

void Localizer::begin_tracking(const Pose2& map_from_robot, const Eigen::Matrix3d& covariance) {
  tracking_ = true;
  map_from_robot_ = map_from_robot;
  covariance_ = covariance;
  // What is not asked for is not done: no loops, no jumps.
  session_.defer_loop_work();
  session_from_robot_ = {};
  last_match_.reset();
  note_confirmed();
}

void Localizer::note_confirmed() {
  contradicted_m_ = unknown_m_ = 0.0;
  tracking_broken_ = false;
}

SlamUpdate Localizer::process(const SlamInput& input) {
  return tracking_ ? track(input) : look(input);
}

SlamUpdate Localizer::look(const SlamInput& input) {
  SlamUpdate update = session_.process(input);
  update.status = SlamUpdate::Status::lost;
  const int session = static_cast<int>(map_from_sessions_.size()) - 1;
  if (path_is_kept_) scans_.push_back({session, update.world_from_robot});
  if (!update.became_key) return update;
  const std::optional<FoundPlace> found = finder_.look(session_.keys());
  if (!found) return update;
  const Keyframe& newest = session_.keys().back();
  map_from_sessions_.back() = found->map_from_robot * newest.world_from_robot.inverse();
  findings_.push_back({input.scan.utime, newest.path_m, *found});
  motion_.restore(session_.state().motion);
  begin_tracking(found->map_from_robot, found->covariance);
  session_from_robot_ = update.world_from_robot;
  last_match_ = input.scan.utime;
  update.world_from_robot = found->map_from_robot;
  update.covariance = found->covariance;
  update.overlap = found->overlap;
  update.status = SlamUpdate::Status::matched;
  update.trajectory_changed = true;
  return update;
}

Localizer::Move Localizer::move_to(const SlamInput& input) {
  const MotionGuess guess = motion_.guess(input.motion);
  Move move{guess.before_from_now, guess.covariance, false};
  const bool is_first = session_.key_count() == 0;
  const Pose2 before = session_from_robot_;
  const SlamUpdate own = session_.process(input);
  session_from_robot_ = own.world_from_robot;
  if (is_first) return move;
  move.seen =
      own.status == SlamUpdate::Status::matched && own.overlap >= slam_options_.gates.good_overlap;
  if (move.seen) {
    move.before_from_now = between(before, own.world_from_robot);
    const double sigma_m = kSeenPart * move.before_from_now.translation_m().norm() + kSeenSigmaM;
    const double sigma_rad =
        kSeenPart * std::abs(move.before_from_now.theta_rad) + deg_to_rad(kSeenSigmaDeg);
    move.covariance =
        Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
  }
  if (session_.key_count() > kSessionKeys) {
    const MotionState motion = session_.state().motion;
    session_ = Slam(slam_options_);
    session_.defer_loop_work();
    SlamState start;
    start.motion = motion;
    session_.restore(start);
    session_from_robot_ = session_.process(input).world_from_robot;
  }
  return move;
}

PosePrior Localizer::prior_of(const Move& move, Eigen::Matrix3d& covariance) const {
  const Pose2 prediction = map_from_robot_ * move.before_from_now;
  Eigen::Matrix3d carry = Eigen::Matrix3d::Identity();
  carry(0, 2) = -(prediction.y_m - map_from_robot_.y_m);
  carry(1, 2) = prediction.x_m - map_from_robot_.x_m;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = map_from_robot_.rotation();
  covariance = carry * covariance_ * carry.transpose() + turn * move.covariance * turn.transpose();
  return {prediction, inverse_of(covariance)};
}

bool Localizer::contradicts(const Beams& beams, const Pose2& map_from_robot) const {
  return map_->places().agreement(beams, map_from_robot).in_free > options_.max_contradicted;
}

SurfelMatch Localizer::match(const OrientedPoints& points,
                             const Beams& beams,
                             const PosePrior& prior,
                             bool seen) {
  const SurfelMatch fine = map_->match(points, prior.map_from_robot, &prior);
  if (fine.overlap >= slam_options_.gates.good_overlap) return fine;
  // In a place that the map does not know there is nothing to search for.
  if (seen && !contradicts(beams, prior.map_from_robot)) return fine;
  const SearchWindow window{prior.map_from_robot, kSearchHalfWidthM,
                            deg_to_rad(kSearchHalfTurnDeg)};
  const CorrelativeMatch wide =
      coarse_.search(map_->places().walls(), points.points, window, kSearchMinScore);
  if (wide.score <= 0.0) return fine;
  const SurfelMatch again = map_->match(points, wide.map_from_robot, nullptr);
  const bool better =
      again.overlap > fine.overlap + 0.05 && !contradicts(beams, again.map_from_robot);
  return better ? again : fine;
}

void Localizer::correct(const OrientedPoints& points,
                        const Beams& beams,
                        const PosePrior& prior,
                        bool seen,
                        SlamUpdate& update) {
  const SurfelMatch found = match(points, beams, prior, seen);
  update.overlap = found.overlap;
  if (found.status == SurfelMatch::Status::no_overlap) return;
  if (found.overlap < options_.good_overlap && seen) {
    const Pose2 off = between(prior.map_from_robot, found.map_from_robot);
    const Eigen::Vector3d moved(found.map_from_robot.x_m - prior.map_from_robot.x_m,
                                found.map_from_robot.y_m - prior.map_from_robot.y_m, off.theta_rad);
    if (moved.dot(prior.information * moved) > kSurprise) return;
  }
  if (found.overlap < (seen ? kSomeOverlap : options_.poor_overlap)) return;
  update.status = SlamUpdate::Status::matched;
  update.world_from_robot = found.map_from_robot;
  update.covariance = map_->covariance_of(found.information + prior.information);
}

SlamUpdate Localizer::track(const SlamInput& input) {
  const Move move = move_to(input);
  SlamUpdate update;
  const PosePrior prior = prior_of(move, update.covariance);
  update.world_from_robot = prior.map_from_robot;
  const bool usable = input.level && input.scan.hits_in_robot.cols() >= slam_options_.gates.min_points;
  Verdict verdict = Verdict::says_nothing;
  if (usable) {
    const OrientedPoints points =
        orient(input.scan.hits_in_robot, input.scan.sensor_in_robot, slam_options_.normals);
    const Beams beams = beams_of(points, input.scan.sensor_in_robot);
    correct(points, beams, prior, move.seen, update);
    verdict = judge(beams, update);
    tracking_broken_ = tracking_broken_ || !move.seen;
  }
  const Pose2 moved = between(map_from_robot_, update.world_from_robot);
  motion_.update(input.motion, moved);
  map_from_robot_ = update.world_from_robot;
  covariance_ = update.covariance;
  if (path_is_kept_) scans_.push_back({-1, map_from_robot_});
  if (!usable) return update;
  note_whether_lost(input.scan.utime, verdict, moved.translation_m().norm());
  if (!tracking_) update.status = SlamUpdate::Status::lost;
  return update;
}

Localizer::Verdict Localizer::judge(const Beams& beams, const SlamUpdate& update) const {
  // A room that resembles the right one has walls where this one is known to be free.
  const Agreement says = map_->places().agreement(beams, update.world_from_robot);
  if (says.in_free > options_.max_contradicted) return Verdict::contradicted;
  if (update.status != SlamUpdate::Status::matched) return Verdict::says_nothing;
  const bool fits = update.overlap >= options_.good_overlap;
  const bool fits_where_known =
      says.explained >= kExplained && says.in_free <= kHardly * says.explained;
  return fits || fits_where_known ? Verdict::confirmed : Verdict::says_nothing;
}

void Localizer::note_whether_lost(Utime utime, Verdict verdict, double moved_m) {
  if (verdict == Verdict::confirmed) note_confirmed();
  // Scans that do not fit each other may have been taken anywhere.
  const bool doubt = verdict == Verdict::contradicted || (verdict != Verdict::confirmed && tracking_broken_);
  if (!doubt || !last_match_) last_match_ = utime;
  unknown_m_ += moved_m;
  contradicted_m_ = doubt ? contradicted_m_ + moved_m : 0.0;
  const double waited_s = std::abs((utime - *last_match_).seconds());
  if (contradicted_m_ <= options_.lost_after_m && waited_s <= options_.lost_after_s &&
      unknown_m_ <= options_.unknown_for_m) {
    return;
  }
  ++times_lost_;
  forget_place();
}

void Localizer::keep_no_path() {
  path_is_kept_ = false;
  scans_ = {};
}

std::vector<std::optional<Pose2>> Localizer::trajectory() const {
  std::vector<std::optional<Pose2>> trajectory;
  for (const ScanPose& scan : scans_) {
    if (scan.session < 0) {
      trajectory.emplace_back(scan.frame_from_robot);
      continue;
    }
    const std::optional<Pose2>& found = map_from_sessions_[static_cast<std::size_t>(scan.session)];
    trajectory.push_back(found ? std::optional<Pose2>(*found * scan.frame_from_robot)
                               : std::nullopt);
  }
  return trajectory;
}

}  // namespace marco::slam
