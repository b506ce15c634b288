#include "slam/localization/localizer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kSearchHalfWidthM = 0.6;
constexpr double kSearchHalfTurnDeg = 20.0;
constexpr double kSearchMinScore = 0.3;

Eigen::Matrix3d inverse_of(const Eigen::Matrix3d& matrix) {
  return (matrix + 1e-9 * Eigen::Matrix3d::Identity()).inverse();
}

}  // namespace

Localizer::Localizer(std::vector<KeyScan> map,
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
  tracking_ = true;
  map_from_robot_ = map_from_robot;
  covariance_ = Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal();
  motion_ = MotionModel(slam_options_.motion);
  last_match_.reset();
  unmatched_m_ = 0.0;
}

SlamUpdate Localizer::process(const SlamInput& input) {
  SlamUpdate update = tracking_ ? track(input) : look(input);
  return update;
}

SlamUpdate Localizer::look(const SlamInput& input) {
  SlamUpdate update = session_.process(input);
  update.status = SlamUpdate::Status::lost;
  const int session = static_cast<int>(map_from_sessions_.size()) - 1;
  scans_.push_back({session, update.world_from_robot});
  if (!update.became_key) return update;
  const std::optional<FoundPlace> found = finder_.look(session_.keys());
  if (!found) return update;
  const KeyScan& newest = session_.keys().back();
  map_from_sessions_.back() = found->map_from_robot * newest.world_from_robot.inverse();
  findings_.push_back({input.scan.utime, newest.path_m, *found});
  motion_.restore(session_.state().motion);
  tracking_ = true;
  map_from_robot_ = update.world_from_robot = found->map_from_robot;
  covariance_ = update.covariance = found->covariance;
  last_match_ = input.scan.utime;
  unmatched_m_ = 0.0;
  update.overlap = found->overlap;
  update.status = SlamUpdate::Status::matched;
  update.trajectory_changed = true;
  return update;
}

SurfelMatch Localizer::match(const OrientedPoints& points, const PosePrior& prior) {
  SurfelMatch fine = map_->match(points, prior.map_from_robot, &prior);
  if (fine.overlap >= slam_options_.good_overlap) return fine;
  const SearchWindow window{prior.map_from_robot, kSearchHalfWidthM,
                            deg_to_rad(kSearchHalfTurnDeg)};
  const CorrelativeMatch wide =
      coarse_.search(map_->places().walls(), points.points, window, kSearchMinScore);
  if (wide.score <= 0.0) return fine;
  const SurfelMatch again = map_->match(points, wide.map_from_robot, nullptr);
  return again.overlap > fine.overlap + 0.05 ? again : fine;
}

SlamUpdate Localizer::track(const SlamInput& input) {
  const MotionGuess guess = motion_.guess(input.motion);
  PosePrior prior;
  prior.map_from_robot = map_from_robot_ * guess.before_from_now;
  Eigen::Matrix3d carry = Eigen::Matrix3d::Identity();
  carry(0, 2) = -(prior.map_from_robot.y_m - map_from_robot_.y_m);
  carry(1, 2) = prior.map_from_robot.x_m - map_from_robot_.x_m;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = map_from_robot_.rotation();
  const Eigen::Matrix3d covariance =
      carry * covariance_ * carry.transpose() + turn * guess.covariance * turn.transpose();
  prior.information = inverse_of(covariance);
  SlamUpdate update;
  update.world_from_robot = prior.map_from_robot;
  update.covariance = covariance;
  const bool usable = input.level && input.scan.hits_in_robot.cols() >= slam_options_.min_points;
  if (usable) {
    const SurfelMatch found = match(
        orient(input.scan.hits_in_robot, input.scan.sensor_in_robot, slam_options_.normals), prior);
    update.overlap = found.overlap;
    if (found.status != SurfelMatch::Status::no_overlap && found.overlap >= options_.poor_overlap) {
      update.status = SlamUpdate::Status::matched;
      update.world_from_robot = found.map_from_robot;
      update.covariance = map_->covariance_of(found.information + prior.information);
    }
  }
  const Pose2 moved = between(map_from_robot_, update.world_from_robot);
  motion_.update(input.motion, moved);
  map_from_robot_ = update.world_from_robot;
  covariance_ = update.covariance;
  scans_.push_back({-1, map_from_robot_});
  if (!usable) return update;
  note_whether_lost(input.scan.utime, fits(input, update), moved.translation_m().norm());
  if (!tracking_) update.status = SlamUpdate::Status::lost;
  return update;
}

bool Localizer::fits(const SlamInput& input, const SlamUpdate& update) const {
  if (update.status != SlamUpdate::Status::matched || update.overlap < options_.good_overlap) {
    return false;
  }
  // A room that resembles the right one has walls where this one is known to be free.
  const PlaceMap& places = map_->places();
  const Points2 hits = update.world_from_robot * input.scan.hits_in_robot;
  constexpr double kFarFromWall = 0.08;
  int contradicted = 0;
  for (Eigen::Index i = 0; i < hits.cols(); ++i) {
    const bool off = places.likelihood(hits.col(i)).value < kFarFromWall;
    if (off && places.is_free(hits.col(i))) ++contradicted;
  }
  return contradicted <= options_.max_contradicted * static_cast<double>(hits.cols());
}

void Localizer::note_whether_lost(Utime utime, bool fits, double moved_m) {
  if (fits || !last_match_) {
    last_match_ = utime;
    unmatched_m_ = 0.0;
    return;
  }
  unmatched_m_ += moved_m;
  const double waited_s = std::abs((utime - *last_match_).seconds());
  if (unmatched_m_ <= options_.lost_after_m && waited_s <= options_.lost_after_s) return;
  ++times_lost_;
  forget_place();
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
