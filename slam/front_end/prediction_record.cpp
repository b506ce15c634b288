#include "slam/front_end/prediction_record.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kForgottenM = 5.0, kForgottenRad = 6.0;
// So much motion has to be missed before a sensor is doubted.
constexpr double kBelievedM = 0.2, kBelievedRad = 0.2;
constexpr double kEnough = 0.5;

// A step teaches odometry's noise where the match is so much surer than odometry is assumed to be.
constexpr double kMuchSurer = 0.25;
constexpr double kAssumedM2 = 10.0, kRememberedM2 = 200.0;

void note(double found, double missed, double forgotten, double& found2, double& missed2) {
  const double kept = 1.0 - std::min(1.0, std::max(found, missed) / forgotten);
  found2 = kept * found2 + found * found;
  missed2 = kept * missed2 + missed * missed;
}

}  // namespace

void PredictionError::update(const Eigen::Vector3d& error) {
  constexpr double kFresh = 0.05;
  m2 += kFresh * (error.head<2>().squaredNorm() - m2);
  rad2 += kFresh * (error.z() * error.z() - rad2);
}

void ExplainedMotion::update(const Pose2& found, const Pose2& measured) {
  note(found.translation_m().norm(), (found.translation_m() - measured.translation_m()).norm(),
       kForgottenM, found_m2, missed_m2);
  note(std::abs(found.theta_rad), std::abs(normalize_angle(found.theta_rad - measured.theta_rad)),
       kForgottenRad, found_rad2, missed_rad2);
}

bool ExplainedMotion::explains_translation() const {
  return missed_m2 <= (1.0 - kEnough) * (found_m2 + kBelievedM * kBelievedM);
}

bool ExplainedMotion::explains_rotation() const {
  return missed_rad2 <= (1.0 - kEnough) * (found_rad2 + kBelievedRad * kBelievedRad);
}

void OdometryNoise::update(const Pose2& found,
                           const Pose2& measured,
                           double sigma_m,
                           double assumed_per_m) {
  const double step_m2 = found.translation_m().squaredNorm();
  if (!(sigma_m < kMuchSurer * assumed_per_m * std::sqrt(step_m2))) return;
  const double kept = std::max(0.0, 1.0 - step_m2 / kRememberedM2);
  way_m2 = kept * way_m2 + step_m2;
  off_m2 = kept * off_m2 + 0.5 * (found.translation_m() - measured.translation_m()).squaredNorm();
}

double OdometryNoise::sigma_per_m(double assumed_per_m) const {
  const double learned =
      std::sqrt((assumed_per_m * assumed_per_m * kAssumedM2 + off_m2) / (kAssumedM2 + way_m2));
  return std::min(learned, assumed_per_m);
}

}  // namespace marco::slam
