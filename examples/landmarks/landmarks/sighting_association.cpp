#include "landmarks/sighting_association.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "slam/line_slam/ekf/joint_compatibility.hpp"

namespace marco::slam {
namespace {

// Twice the logarithm of how much likelier the best pairing must be than the next.
constexpr double kClearBy = 4.0;
// What is nearer than this many gates to a landmark is not a new one, unless that is paired.
constexpr double kNearGates = 2.5;

struct Possible {
  Pairing pairing;
  PointInnovation rows;
  int landmark = 0;
};

/// Landmarks by sighting.
class Possibilities {
 public:
  Possibilities(const PointFilter& filter,
                const std::vector<Sighting>& sightings,
                const SightingNoise& noise)
      : filter_(filter), noise_(noise) {
    for (int i = 0; i < filter.size(); ++i) places_.push_back(filter.in_sensor(i));
    for (std::size_t k = 0; k < sightings.size(); ++k) add(sightings[k], static_cast<int>(k));
  }
  const std::vector<Possible>& all() const { return all_; }

 private:
  void add(const Sighting& sighting, int observation) {
    const Eigen::Vector2d at = point_of(sighting);
    // No landmark can be as uncertain as to reach farther than this.
    const Eigen::Matrix3d robot = filter_.robot_covariance();
    const double reach_m =
        1.0 + 8.0 * (std::sqrt(robot(0, 0) + robot(1, 1)) + noise_.range_sigma_m +
                     sighting.range_m * (std::sqrt(robot(2, 2)) + noise_.bearing_sigma_rad));
    for (int landmark = 0; landmark < filter_.size(); ++landmark) {
      if ((places_[static_cast<std::size_t>(landmark)] - at).squaredNorm() > reach_m * reach_m) {
        continue;
      }
      Possible possible;
      possible.landmark = landmark;
      possible.rows = filter_.innovation({sighting, landmark});
      Pairing& pairing = possible.pairing;
      pairing.observation = observation;
      pairing.only_once = landmark;
      pairing.innovation = possible.rows.innovation;
      pairing.covariance =
          filter_.innovation_covariance(possible.rows, landmark, possible.rows, landmark);
      pairing.covariance(0, 0) += noise_.range_sigma_m * noise_.range_sigma_m;
      pairing.covariance(1, 1) += noise_.bearing_sigma_rad * noise_.bearing_sigma_rad;
      pairing.distance2 = pairing.innovation.dot(pairing.covariance.inverse() * pairing.innovation);
      all_.push_back(possible);
    }
  }

  const PointFilter& filter_;
  const SightingNoise& noise_;
  std::vector<Eigen::Vector2d> places_;
  std::vector<Possible> all_;
};

}  // namespace

std::vector<SightingMatch> associate_sightings(const PointFilter& filter,
                                               const std::vector<Sighting>& sightings,
                                               const SightingNoise& noise,
                                               double gate_probability) {
  const Possibilities possibilities(filter, sightings, noise);
  const double gate2 = chi_square_limit(2, gate_probability);
  std::vector<const Possible*> inside;
  std::vector<Pairing> pairings;
  for (const Possible& possible : possibilities.all()) {
    if (possible.pairing.distance2 > gate2) continue;
    inside.push_back(&possible);
    pairings.push_back(possible.pairing);
  }
  const auto at = [&](int i) -> const Possible& { return *inside[static_cast<std::size_t>(i)]; };
  const std::vector<int> chosen = joint_compatibility(
      pairings,
      [&](int a, int b) {
        return filter.innovation_covariance(at(a).rows, at(a).landmark, at(b).rows, at(b).landmark);
      },
      static_cast<int>(sightings.size()), gate_probability);

  std::vector<SightingMatch> matches(sightings.size());
  std::vector<bool> paired(static_cast<std::size_t>(filter.size()), false);
  std::vector<double> best(sightings.size(), std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (chosen[k] < 0) continue;
    matches[k].landmark = at(chosen[k]).landmark;
    paired[static_cast<std::size_t>(matches[k].landmark)] = true;
    best[k] = at(chosen[k]).pairing.distance2;
  }
  const std::vector<SightingMatch> as_chosen = matches;
  for (const Possible& possible : possibilities.all()) {
    const auto k = static_cast<std::size_t>(possible.pairing.observation);
    const bool is_free = !paired[static_cast<std::size_t>(possible.landmark)];
    const double distance2 = possible.pairing.distance2;
    if (as_chosen[k].landmark == SightingMatch::kNew) {
      if (is_free && distance2 < kNearGates * gate2) matches[k].landmark = SightingMatch::kUnclear;
    } else if (is_free && distance2 < best[k] + kClearBy) {
      matches[k].landmark = SightingMatch::kUnclear;
    }
  }
  return matches;
}

}  // namespace marco::slam
