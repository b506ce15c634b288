#include "landmarks/provisional_landmarks.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kGate2 = 11.8;         // chi-square, 2 degrees of freedom, 99.7 %
constexpr double kLeastSeenPart = 0.3;  // of the scans that should have seen it
constexpr int kMostScansUnseen = 300;
constexpr double kDriftPart = 0.01;  // the robot's own drift, of the range

}  // namespace

int ProvisionalLandmarks::nearest(const Eigen::Vector2d& at_m,
                                  const Eigen::Matrix2d& covariance,
                                  const std::vector<bool>& taken) const {
  int best = -1;
  double best2 = kGate2;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (taken[i]) continue;
    const Eigen::Vector2d off = at_m - places_[i].mean_m;
    const double distance2 = off.dot((places_[i].covariance + covariance).inverse() * off);
    if (distance2 < best2) {
      best2 = distance2;
      best = static_cast<int>(i);
    }
  }
  return best;
}

std::vector<Sighting> ProvisionalLandmarks::add_scan(const std::vector<Sighting>& sightings,
                                                     const PointFilter& filter,
                                                     const Visibility& visibility,
                                                     const SightingNoise& noise,
                                                     int needed) {
  std::vector<Sighting> confirmed;
  std::vector<bool> taken(places_.size(), false);
  std::vector<Place> fresh;
  for (const Sighting& sighting : sightings) {
    const Eigen::Vector2d at = filter.in_world(sighting);
    const double drift_m = kDriftPart * sighting.range_m;
    const Eigen::Matrix2d covariance = filter.sighting_covariance(sighting, noise) +
                                       drift_m * drift_m * Eigen::Matrix2d::Identity();
    const int found = nearest(at, covariance, taken);
    if (found < 0) {
      if (needed <= 1) {
        confirmed.push_back(sighting);
      } else {
        fresh.push_back({at, covariance});
      }
      continue;
    }
    Place& place = places_[static_cast<std::size_t>(found)];
    taken[static_cast<std::size_t>(found)] = true;
    const Eigen::Matrix2d gain = place.covariance * (place.covariance + covariance).inverse();
    place.mean_m += gain * (at - place.mean_m);
    place.covariance -= (gain * place.covariance).eval();
    place.covariance += drift_m * drift_m * Eigen::Matrix2d::Identity();
    ++place.seen;
    place.expected += 1.0;
    place.scans_since = 0;
    if (place.seen >= needed && place.seen > kLeastSeenPart * place.expected) {
      confirmed.push_back(sighting);
      place.seen = 0;  // leaves below
    }
  }
  const Pose2 sensor_from_world =
      (filter.world_from_robot() *
       Pose2{filter.set_up()[sensor_x], filter.set_up()[sensor_y], filter.set_up()[sensor_yaw]})
          .inverse();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Place& place = places_[i];
    if (taken[i]) continue;
    ++place.scans_since;
    const Eigen::Vector2d at = sensor_from_world * place.mean_m;
    if (visibility.probability(at.norm(), std::atan2(at.y(), at.x())) > 0.0) place.expected += 1.0;
  }
  std::erase_if(places_, [&](const Place& place) {
    return place.seen == 0 || place.scans_since > kMostScansUnseen ||
           place.seen < kLeastSeenPart * (place.expected - 3.0);
  });
  places_.insert(places_.end(), fresh.begin(), fresh.end());
  return confirmed;
}

}  // namespace marco::slam
