#include "slam/localization/frozen_map.hpp"

#include <algorithm>

namespace marco::slam {

Beams beams_of(const OrientedPoints& points_in_robot, const Eigen::Vector2d& sensor_in_robot) {
  const Points2& ends = points_in_robot.points;
  Beams beams{ends, sensor_in_robot.replicate(1, ends.cols()), {}};
  for (Eigen::Index i = 0; i < ends.cols(); ++i) {
    beams.clear_m.push_back(
        clear_length_m(ends.col(i) - sensor_in_robot, points_in_robot.normals.col(i)));
  }
  return beams;
}

FrozenMap::FrozenMap(std::vector<Keyframe> keys,
                     const LocalizerOptions& options,
                     const SlamOptions& slam)
    : keys_(std::move(keys)),
      options_(options),
      matcher_(slam.fine),
      coarse_(slam.coarse),
      places_(keys_, options.map) {
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

void FrozenMap::rebuild_local_map(const Eigen::Vector2d& centre_m) {
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
  if (!local_ || (at - local_centre_m_).norm() > options_.renew_after_m) rebuild_local_map(at);
  return matcher_.match(*local_, points_in_robot, map_from_robot_guess, prior);
}

Eigen::Matrix3d FrozenMap::covariance_of(const Eigen::Matrix3d& information) const {
  return marco::covariance_of(information) +
         diagonal_covariance(options_.map_sigma_m, deg_to_rad(options_.map_sigma_deg));
}

std::optional<SurfelMatch> FrozenMap::match_widely(const OrientedPoints& points_in_robot,
                                                   const Pose2& map_from_robot_guess) {
  constexpr double kHalfWidthM = 0.6, kHalfTurnDeg = 20.0,
                   kMinScore = 0.3;  // a slip between two scans, not a place
  const SearchWindow window{map_from_robot_guess, kHalfWidthM, deg_to_rad(kHalfTurnDeg)};
  const CorrelativeMatch coarse =
      coarse_.search(places_.walls(), points_in_robot.points, window, kMinScore);
  if (coarse.score <= 0.0) return std::nullopt;
  return match(points_in_robot, coarse.map_from_robot, nullptr);
}

}  // namespace marco::slam
