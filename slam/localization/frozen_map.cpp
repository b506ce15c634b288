#include <Eigen/LU>
#include <algorithm>

#include "slam/localization/localizer.hpp"

namespace marco::slam {

FrozenMap::FrozenMap(std::vector<Keyframe> keys,
                     const LocalizerOptions& options,
                     const SlamOptions& slam)
    : keys_(std::move(keys)), options_(options), matcher_(slam.fine), places_(keys_, options.map) {
  validate(options, "localizer");
}

int FrozenMap::nearest_key(const Pose2& map_from_robot) const {
  const auto distance2 = [&](const Keyframe& key) {
    return (key.world_from_robot.translation_m() - map_from_robot.translation_m()).squaredNorm();
  };
  const auto nearest = std::min_element(
      keys_.begin(), keys_.end(),
      [&](const Keyframe& a, const Keyframe& b) { return distance2(a) < distance2(b); });
  return static_cast<int>(nearest - keys_.begin());
}

void FrozenMap::renew(const Eigen::Vector2d& centre_m) {
  struct Near {
    double distance_m;
    const Keyframe* key;
  };
  std::vector<Near> near;
  for (const Keyframe& key : keys_) {
    const double distance_m = (key.world_from_robot.translation_m() - centre_m).norm();
    if (distance_m <= options_.local_radius_m) near.push_back({distance_m, &key});
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const Near& a, const Near& b) { return a.distance_m < b.distance_m; });
  if (static_cast<int>(near.size()) > options_.local_keyframes) {
    near.resize(static_cast<std::size_t>(options_.local_keyframes));
  }
  local_.emplace(matcher_.options(), centre_m);
  local_centre_m_ = centre_m;
  for (const Near& one : near) local_->add(one.key->points_in_robot, one.key->world_from_robot);
}

SurfelMatch FrozenMap::match(const OrientedPoints& points_in_robot,
                             const Pose2& map_from_robot_guess,
                             const PosePrior* prior) {
  const Eigen::Vector2d at = map_from_robot_guess.translation_m();
  if (!local_ || (at - local_centre_m_).norm() > options_.renew_after_m) renew(at);
  return matcher_.match(*local_, points_in_robot, map_from_robot_guess, prior);
}

Eigen::Matrix3d FrozenMap::covariance_of(const Eigen::Matrix3d& information) const {
  Eigen::Matrix3d covariance = (information + 1e-6 * Eigen::Matrix3d::Identity()).inverse();
  covariance(0, 0) += options_.map_sigma_m * options_.map_sigma_m;
  covariance(1, 1) += options_.map_sigma_m * options_.map_sigma_m;
  const double sigma_rad = deg_to_rad(options_.map_sigma_deg);
  covariance(2, 2) += sigma_rad * sigma_rad;
  return covariance;
}

SessionFinder::SessionFinder(FrozenMap& map, const LocalizerOptions& options)
    : map_(&map), options_(options), finder_(map.places(), options.finder) {}

void SessionFinder::restart() {
  finder_.restart();
  estimate_ = {};
  began_m_.reset();
}

std::optional<FoundPlace> SessionFinder::look(const std::vector<Keyframe>& session) {
  // A look costs as much as a hundred scans; in a strange building all would be in vain.
  constexpr double kEagerM = 15.0, kSeldomM = 2.0;
  const double path_m = session.back().path_m;
  if (!began_m_) began_m_ = path_m;
  const bool is_eager = path_m - *began_m_ <= kEagerM || finder_.has_leader();
  if (!is_eager && path_m - looked_m_ < kSeldomM) return std::nullopt;
  looked_m_ = path_m;
  estimate_ = finder_.look(session);
  if (estimate_.status != PlaceEstimate::Status::localized) return std::nullopt;
  const Keyframe& newest = session.back();
  const Pose2 guess = estimate_.candidates.front().map_from_session * newest.world_from_robot;
  const SurfelMatch fine = map_->match(newest.points_in_robot, guess, nullptr);
  // The finder is right to some centimetres; a match that goes elsewhere speaks against it.
  constexpr double kAgreesM = 0.3;
  const Pose2 moved = between(guess, fine.map_from_robot);
  const double wanted =
      std::min(options_.good_overlap, 0.8 * estimate_.candidates.front().explained);
  if (fine.status == SurfelMatch::Status::no_overlap || fine.overlap < wanted ||
      moved.translation_m().norm() > kAgreesM ||
      std::abs(moved.theta_rad) > deg_to_rad(options_.finder.apart_deg)) {
    estimate_.status = PlaceEstimate::Status::candidates;
    return std::nullopt;
  }
  return FoundPlace{fine.map_from_robot, map_->covariance_of(fine.information), fine.overlap,
                    map_->nearest_key(fine.map_from_robot)};
}

}  // namespace marco::slam
