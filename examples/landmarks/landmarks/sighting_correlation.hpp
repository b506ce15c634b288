#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>

namespace marco::slam {

/// How far sightings of one landmark repeat each other's errors: a tree is seen from one side for
/// many scans, and its middle is misjudged in all of them alike. Innovations of a filter whose
/// sightings are independent are white; the mean of a stretch of them then has the variance 1 / n.
/// What it has more is the factor by which each sighting's noise must be taken larger (the
/// integrated autocorrelation time, by batch means). Not thread-safe.
class SightingCorrelation {
 public:
  SightingCorrelation();

  /// @param landmark  id. @param innovation  per component over its standard deviation.
  /// @param scan      number of the scan
  void add(int64_t landmark, const Eigen::Vector2d& innovation, int64_t scan);

  /// Ends all stretches: landmarks get other ids.
  void renumber() { stretches_.clear(); }

  /// At least 1.
  double noise_factor() const;

 private:
  struct Stretch {
    int count = 0;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int64_t last_scan = 0;
  };
  void close(Stretch& stretch);

  std::map<int64_t, Stretch> stretches_;
  double sum_;
  double weight_;
};

}  // namespace marco::slam
