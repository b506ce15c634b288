#include "slam/front_end/prediction_record.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

// Of motion, after which a sensor's past counts 1/e: one way through a room, one full turn.
constexpr double kForgottenM = 5.0, kForgottenRad = 6.0;
// So much motion has to be missed before a sensor is doubted.
constexpr double kBelievedM = 0.2, kBelievedRad = 0.2;
constexpr double kEnough = 0.5;

// So much surer than a step a match is to judge it.
constexpr double kMuchSurer = 0.25;

// An outlier counts for no more than a sensor that reports no motion. Otherwise a single jump of
// odometry would outweigh everything that it has explained.
void note(double found,
          double missed,
          double believed,
          double forgotten,
          double& found2,
          double& missed2) {
  missed = std::min(missed, std::max(found, believed));
  const double kept = 1.0 - std::min(1.0, std::max(found, missed) / forgotten);
  found2 = kept * found2 + found * found;
  missed2 = kept * missed2 + missed * missed;
}

}  // namespace

void PredictionError::update(const Eigen::Vector3d& error, bool position_known) {
  constexpr double kFresh = 0.05;  // weight of the newest: the last 20 steps
  if (position_known) m2 += kFresh * (error.head<2>().squaredNorm() - m2);
  rad2 += kFresh * (error.z() * error.z() - rad2);
}

void ExplainedMotion::update(const Pose2& found, const Pose2& measured, double sigma_m) {
  const double found_m = found.translation_m().norm(), told_m = measured.translation_m().norm();
  if (sigma_m < kMuchSurer * std::max(found_m, told_m)) {
    note(found_m, (found.translation_m() - measured.translation_m()).norm(), kBelievedM,
         kForgottenM, found_m2, missed_m2);
  }
  note(std::abs(found.theta_rad), std::abs(normalize_angle(found.theta_rad - measured.theta_rad)),
       kBelievedRad, kForgottenRad, found_rad2, missed_rad2);
}

bool ExplainedMotion::explains_translation() const {
  return missed_m2 <= (1.0 - kEnough) * (found_m2 + kBelievedM * kBelievedM);
}

bool ExplainedMotion::explains_rotation() const {
  return missed_rad2 <= (1.0 - kEnough) * (found_rad2 + kBelievedRad * kBelievedRad);
}

}  // namespace marco::slam
