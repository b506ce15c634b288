#include "slam/map/local_map.hpp"

#include <algorithm>

namespace marco::slam {

LocalMap::LocalMap(const LocalMapOptions& options,
                   const SurfelMatcherOptions& surfels,
                   const CorrelativeMatcherOptions& likelihood)
    : options_(options), surfel_options_(surfels), likelihood_options_(likelihood) {}

int LocalMap::first_of(const KeyframeSet& keyframes) const {
  const int beyond = keyframes.ever() - options_.window_keyframes;
  const int step = options_.window_slack + 1;
  return std::max(0, beyond) / step * step;
}

double LocalMap::extend(const KeyframeSet& keyframes) {
  likelihood_.reset();
  if (!surfels_ || first_of(keyframes) != first_) {
    return rebuild(keyframes);
  }
  const Keyframe& newest = keyframes.keys.back();
  return surfels_->add(newest.points_in_robot, newest.world_from_robot);
}

double LocalMap::rebuild(const KeyframeSet& keyframes) {
  // In the middle of what the map will cover, whenever it is made.
  const int first_key = std::max(0, first_of(keyframes) - keyframes.merged);
  const int middle = std::min(static_cast<int>(keyframes.keys.size()) - 1,
                              first_key + options_.window_keyframes - 1);
  return fill(keyframes,
              keyframes.keys[static_cast<std::size_t>(middle)].world_from_robot.translation_m());
}

void LocalMap::restore(const KeyframeSet& keyframes, const Eigen::Vector2d& centre_m) {
  surfels_.reset();
  likelihood_.reset();
  if (!keyframes.keys.empty()) fill(keyframes, centre_m);
}

double LocalMap::fill(const KeyframeSet& keyframes, const Eigen::Vector2d& centre_m) {
  likelihood_.reset();
  first_ = first_of(keyframes);
  if (!surfels_) surfels_.emplace(surfel_options_, centre_m);
  surfels_->restart(centre_m);
  const auto first_key = static_cast<std::size_t>(std::max(0, first_ - keyframes.merged));
  double of_before = 0.0;
  for (std::size_t key = first_key; key < keyframes.keys.size(); ++key) {
    of_before =
        surfels_->add(keyframes.keys[key].points_in_robot, keyframes.keys[key].world_from_robot);
  }
  return of_before;
}

const LikelihoodPyramid& LocalMap::likelihood(const KeyframeSet& keyframes) {
  if (likelihood_) return *likelihood_;
  const int last = static_cast<int>(keyframes.keys.size()) - 1;
  const int first = std::max(0, last - options_.window_keyframes + 1);
  const OrientedPoints map = join_points(keyframes.keys, first, last, Pose2{});
  const Eigen::Vector2d centre_m = keyframes.keys.back().world_from_robot.translation_m();
  return likelihood_.emplace(points_within(kSearchReachM, centre_m, map.points),
                             adapted(likelihood_options_, map.range_sigma_m));
}

Eigen::Vector2d LocalMap::centre_m() const {
  return surfels_ ? Eigen::Vector2d(surfels_->levels().front().centre_m()) : Eigen::Vector2d(0, 0);
}

}  // namespace marco::slam
