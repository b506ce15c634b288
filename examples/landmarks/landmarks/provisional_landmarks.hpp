#pragma once

#include <Eigen/Core>
#include <vector>

#include "landmarks/point_filter.hpp"
#include "landmarks/visibility.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::slam {

/// Sightings that no landmark of the filter explains, until enough of them agree. They do not
/// correct anything: a landmark joins the filter by its last sighting alone, so that none is used
/// twice. Not thread-safe.
class ProvisionalLandmarks {
 public:
  /// @param sightings  one scan's unexplained ones
  /// @param needed     sightings of a landmark before it is confirmed
  /// @returns those by which landmarks are to join the filter
  std::vector<Sighting> add_scan(const std::vector<Sighting>& sightings,
                                 const PointFilter& filter,
                                 const Visibility& visibility,
                                 const SightingNoise& noise,
                                 int needed);

  std::size_t size() const { return places_.size(); }

 private:
  struct Place {
    Eigen::Vector2d mean_m;      ///< world
    Eigen::Matrix2d covariance;  ///< without the robot's
    int seen = 1;
    double expected = 1.0;  ///< scans in which it should have been seen
    int scans_since = 0;    ///< the last sighting
  };
  int nearest(const Eigen::Vector2d& at_m,
              const Eigen::Matrix2d& covariance,
              const std::vector<bool>& taken) const;

  std::vector<Place> places_;
};

}  // namespace marco::slam
