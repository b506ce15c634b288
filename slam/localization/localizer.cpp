#include "slam/localization/localizer.hpp"

#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/localization/place_gates.hpp"

namespace marco::slam {
namespace {

// Of a motion from scans, besides its own length and turn.
constexpr double kSigmaPart = 0.02;
constexpr double kSigmaM = 5e-4;
constexpr double kSigmaDeg = 0.01;

// Keyframes before the session is restarted.
constexpr std::size_t kMostKeyframes = 150;

}  // namespace

void TrackingState::begin(std::optional<Utime> confirmed_at) {
  last_match_ = confirmed_at;
  contradicted_m_ = unknown_m_ = 0.0;
  tracking_broken_ = false;
}

bool TrackingState::is_lost_after(
    Utime utime, Verdict verdict, bool moves_fit, double moved_m, const TrackingLimits& limits) {
  tracking_broken_ = tracking_broken_ || !moves_fit;
  if (verdict == Verdict::confirmed) {
    contradicted_m_ = unknown_m_ = 0.0;
    tracking_broken_ = false;
  }
  // Scans that do not fit each other may have been taken anywhere.
  const bool doubtful =
      verdict == Verdict::contradicted || (verdict != Verdict::confirmed && tracking_broken_);
  if (!doubtful || !last_match_) last_match_ = utime;
  unknown_m_ += moved_m;
  contradicted_m_ = doubtful ? contradicted_m_ + moved_m : 0.0;
  const double waited_s = std::abs((utime - *last_match_).seconds());
  const bool lost = contradicted_m_ > limits.contradicted_m || waited_s > limits.contradicted_s ||
                    unknown_m_ > limits.unknown_m;
  if (lost) ++times_lost_;
  return lost;
}

ScanOdometry::ScanOdometry(const SlamOptions& options) : options_(options), session_(options) {}

void ScanOdometry::begin(const Pose2& session_from_robot) {
  // Loop work that nobody takes is not done: no loops, no jumps.
  session_.defer_loop_work();
  session_from_robot_ = session_from_robot;
}

void ScanOdometry::reset() { session_ = Slam(options_); }

ScanOdometry::Move ScanOdometry::move(const SlamInput& input, const MotionGuess& guess) {
  Move move{guess.before_from_now, guess.covariance()};
  const bool is_first = session_.key_count() == 0;
  const Pose2 before = session_from_robot_;
  const SlamUpdate own = session_.process(input);
  session_from_robot_ = own.world_from_robot;
  if (is_first) return move;
  move.by_scans =
      own.status == SlamUpdate::Status::matched && own.overlap >= options_.gates.good_overlap;
  if (move.by_scans) {
    move.before_from_now = between(before, own.world_from_robot);
    const double sigma_m = kSigmaPart * move.before_from_now.translation_m().norm() + kSigmaM;
    const double sigma_rad =
        kSigmaPart * std::abs(move.before_from_now.theta_rad) + deg_to_rad(kSigmaDeg);
    move.covariance = diagonal_covariance(sigma_m, sigma_rad);
  }
  if (session_.key_count() > kMostKeyframes) {
    SlamState start;
    start.motion = session_.state().motion;
    session_ = Slam(options_);
    session_.restore(start);
    begin(session_.process(input).world_from_robot);
  }
  return move;
}

using namespace place_gates;

void LocalizedPath::keep_nothing() {
  is_kept_ = false;
  scans_ = {};
}

void LocalizedPath::add_unplaced(const Pose2& session_from_robot) {
  const int session = static_cast<int>(map_from_sessions_.size()) - 1;
  if (is_kept_) scans_.push_back({session, session_from_robot});
}

void LocalizedPath::add(const Pose2& map_from_robot) {
  if (is_kept_) scans_.push_back({-1, map_from_robot});
}

std::vector<std::optional<Pose2>> LocalizedPath::poses() const {
  std::vector<std::optional<Pose2>> poses;
  for (const ScanPose& scan : scans_) {
    std::optional<Pose2> map_from_frame = Pose2{};
    if (scan.session >= 0)
      map_from_frame = map_from_sessions_[static_cast<std::size_t>(scan.session)];
    poses.push_back(map_from_frame ? std::optional(*map_from_frame * scan.frame_from_robot)
                                   : std::nullopt);
  }
  return poses;
}

Localizer::Localizer(std::vector<Keyframe> map,
                     const LocalizerOptions& options,
                     const SlamOptions& slam)
    : options_(options),
      gates_(slam.gates),
      normals_(slam.normals),
      map_(std::make_unique<FrozenMap>(std::move(map), options, slam)),
      finder_(*map_, options),
      odometry_(slam),
      motion_(slam.motion) {}

void Localizer::forget_place() {
  tracking_ = false;
  odometry_.reset();
  finder_.restart();
  path_.begin_session();
}

void Localizer::set_pose(const Pose2& map_from_robot) {
  require(is_finite(map_from_robot), "localizer: the pose is not finite");
  constexpr double kSigmaM = 0.2, kSigmaRad = 0.1;  // of a click on the map
  forget_place();
  motion_.restore({});
  odometry_.begin({});
  begin_tracking({map_from_robot, diagonal_covariance(kSigmaM, kSigmaRad)});
  tracking_state_.begin(std::nullopt);
}

void Localizer::begin_tracking(const PoseWithCovariance& estimate) {
  tracking_ = true;
  estimate_ = estimate;
}

SlamUpdate Localizer::process(const SlamInput& input) {
  return tracking_ ? track(input) : search(input);
}

SlamUpdate Localizer::search(const SlamInput& input) {
  Slam& session = odometry_.session();
  SlamUpdate update = session.process(input);
  update.status = SlamUpdate::Status::lost;
  path_.add_unplaced(update.world_from_robot);
  if (!update.became_key) return update;
  const std::optional<FoundPlace> found = finder_.look(session.keys());
  if (!found) return update;
  const Keyframe& newest = session.keys().back();
  path_.place_session(found->map_from_robot * newest.world_from_robot.inverse());
  findings_.push_back({input.scan.utime, newest.path_m, *found});
  motion_.restore(session.state().motion);
  odometry_.begin(update.world_from_robot);
  begin_tracking({found->map_from_robot, found->covariance});
  tracking_state_.begin(input.scan.utime);
  update.world_from_robot = found->map_from_robot;
  update.covariance = found->covariance;
  update.overlap = found->overlap;
  update.status = SlamUpdate::Status::matched;
  update.trajectory_changed = true;
  return update;
}

SlamUpdate Localizer::track(const SlamInput& input) {
  const ScanOdometry::Move move = odometry_.move(input, motion_.guess(input.motion));
  const PoseWithCovariance predicted =
      dead_reckoned(estimate_, move.before_from_now, move.covariance);
  const PosePrior prior{predicted.world_from_robot, information_of(predicted.covariance)};
  SlamUpdate update;
  update.world_from_robot = predicted.world_from_robot;
  update.covariance = predicted.covariance;
  const bool usable = input.level && input.scan.hits_in_robot.cols() >= gates_.min_points;
  TrackingState::Verdict verdict = TrackingState::Verdict::says_nothing;
  if (usable) {
    noise_.add(input.scan.hits_in_robot, input.scan.sensor_in_robot);
    View view{
        orient(input.scan.hits_in_robot, input.scan.sensor_in_robot, normals_, noise_.sigma_m()),
        {}};
    view.beams = beams_of(view.points, input.scan.sensor_in_robot);
    correct(view, prior, move.by_scans, update);
    verdict = judge(view.beams, update);
  }
  const Pose2 moved = between(estimate_.world_from_robot, update.world_from_robot);
  motion_.update(input.motion, moved, move.by_scans);
  estimate_ = {update.world_from_robot, update.covariance};
  path_.add(update.world_from_robot);
  const TrackingLimits limits{options_.lost_after_m, options_.lost_after_s, options_.unknown_for_m};
  if (usable && tracking_state_.is_lost_after(input.scan.utime, verdict, move.by_scans,
                                              moved.translation_m().norm(), limits)) {
    forget_place();
    update.status = SlamUpdate::Status::lost;
  }
  return update;
}

bool Localizer::contradicts(const Beams& beams, const Pose2& map_from_robot) const {
  return map_->places().agreement(beams, map_from_robot).in_free > options_.max_contradicted;
}

SurfelMatch Localizer::match(const View& view, const PosePrior& prior, bool by_scans) {
  SurfelMatch fine = map_->match(view.points, prior.map_from_robot, &prior);
  if (fine.overlap >= gates_.good_overlap) return fine;
  // In a place that the map does not know there is nothing to search for.
  if (by_scans && !contradicts(view.beams, prior.map_from_robot)) return fine;
  const auto wide = map_->match_widely(view.points, prior.map_from_robot);
  const bool better = wide && wide->overlap > fine.overlap + match_gates::kClearlyBetter &&
                      !contradicts(view.beams, wide->map_from_robot);
  return better ? *wide : fine;
}

void Localizer::correct(const View& view,
                        const PosePrior& prior,
                        bool by_scans,
                        SlamUpdate& update) {
  const SurfelMatch found = match(view, prior, by_scans);
  update.overlap = found.overlap;
  if (found.status == SurfelMatch::Status::no_overlap) return;
  if (found.overlap < options_.good_overlap && by_scans) {
    const Eigen::Vector3d innovation = difference(found.map_from_robot, prior.map_from_robot);
    if (squared_mahalanobis_distance(innovation, prior.information) > match_gates::kContradiction) {
      return;
    }
  }
  if (found.overlap < (by_scans ? kSomeOverlap : options_.poor_overlap)) return;
  update.status = SlamUpdate::Status::matched;
  update.world_from_robot = found.map_from_robot;
  update.covariance = map_->covariance_of(found.information + prior.information);
}

TrackingState::Verdict Localizer::judge(const Beams& beams, const SlamUpdate& update) const {
  using Verdict = TrackingState::Verdict;
  // A room that resembles the right one has walls where this one is known to be free.
  const Agreement says = map_->places().agreement(beams, update.world_from_robot);
  if (says.in_free > options_.max_contradicted) return Verdict::contradicted;
  if (update.status != SlamUpdate::Status::matched) return Verdict::says_nothing;
  const bool fits = update.overlap >= options_.good_overlap;
  const bool fits_where_known =
      says.explained >= kExplained && says.in_free <= kHardly * says.explained;
  return fits || fits_where_known ? Verdict::confirmed : Verdict::says_nothing;
}

}  // namespace marco::slam
