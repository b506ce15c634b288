#include "slam/front_end/odometry_errors.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

double squared(double value) { return value * value; }

// Before scans have shown more: of wheels that are off by 2 % from keyframe to keyframe, and of
// stamps that are off by 10 ms.
constexpr double kDriftM = 0.01, kDriftDeg = 0.5;
constexpr double kJitterM = 0.005, kJitterDeg = 0.25;
// No odometry is believed better.
constexpr double kLeastDriftM = 0.002, kLeastDriftDeg = 0.1;
constexpr double kLeastJitterM = 0.003, kLeastJitterDeg = 0.1;

constexpr double kRadianAsM = 0.5;  // by which both wheels of a track of 1 m run

// Number of samples that the assumption counts as, and the most that are remembered.
constexpr double kAssumedSamples = 5.0, kDriftSamples = 20.0, kJitterSamples = 30.0;
// One slip must not decide: the most that a sample may be, in variances.
constexpr double kMostOfVariance = 10.0;
constexpr double kShortestM = 0.05;  // over a shorter way its noise per metre means nothing

double count_one(double& samples, double most) {
  samples = std::min(samples + 1.0, most);
  return 1.0 / samples;
}

void learn(double& variance, double sample, double fresh, double least) {
  variance += fresh * (std::min(sample, kMostOfVariance * variance) - variance);
  variance = std::max(variance, least);
}

// The errors of wheels that were measured. A wider one is learned sooner (8 % to a fifth of itself
// takes 30 m), but exact wheels then learn from scans that see little.
constexpr double kBiasScale = 0.0075, kBiasTurnPerM = 0.002;
// What is forgotten on a metre.
constexpr double kScalePerM = 0.0007, kTurnPerMPerM = 0.00035;
// Larger errors are slips.
constexpr double kMostScale = 0.5, kMostTurnPerM = 1.0;

Eigen::Matrix3d variances(double scale, double turn_per_m) {
  return Eigen::Vector3d(scale * scale, scale * scale, turn_per_m * turn_per_m).asDiagonal();
}

}  // namespace

double motion_m(const Pose2& way) {
  return way.translation_m().norm() + kRadianAsM * std::abs(way.theta_rad);
}

OdometryNoise::OdometryNoise()
    : drift_per_m(squared(kDriftM), squared(kDriftM), squared(deg_to_rad(kDriftDeg))),
      jitter_m2(squared(kJitterM)),
      jitter_rad2(squared(deg_to_rad(kJitterDeg))),
      drift_samples(kAssumedSamples),
      jitter_samples(kAssumedSamples) {}

Eigen::Matrix3d OdometryNoise::drift(const Pose2& way) const {
  return motion_m(way) * Eigen::Matrix3d(drift_per_m.asDiagonal());
}

Eigen::Matrix3d OdometryNoise::jitter() const {
  return diagonal_covariance(std::sqrt(jitter_m2), std::sqrt(jitter_rad2));
}

void OdometryNoise::learn_drift(const ErrorEstimate& error, double way_m, bool turn_by_odometry) {
  if (way_m < kShortestM) return;
  const Eigen::Vector3d sample =
      (error.mean.cwiseAbs2() + Eigen::Vector3d(error.covariance.diagonal())) / way_m;
  const double fresh = count_one(drift_samples, kDriftSamples);
  learn(drift_per_m.x(), sample.x(), fresh, squared(kLeastDriftM));
  learn(drift_per_m.y(), sample.y(), fresh, squared(kLeastDriftM));
  if (!turn_by_odometry) return;
  learn(drift_per_m.z(), sample.z(), fresh, squared(deg_to_rad(kLeastDriftDeg)));
}

void OdometryNoise::learn_jitter(const ErrorEstimate& error, bool turn_by_odometry) {
  const Eigen::Vector3d sample =
      error.mean.cwiseAbs2() + Eigen::Vector3d(error.covariance.diagonal());
  const double fresh = count_one(jitter_samples, kJitterSamples);
  learn(jitter_m2, 0.5 * (sample.x() + sample.y()), fresh, squared(kLeastJitterM));
  if (!turn_by_odometry) return;
  learn(jitter_rad2, sample.z(), fresh, squared(deg_to_rad(kLeastJitterDeg)));
}

OdometryBias::OdometryBias() : covariance(variances(kBiasScale, kBiasTurnPerM)) {}

Pose2 OdometryBias::corrected(const Pose2& step, bool turn_by_gyro) const {
  const double longer = 1.0 + mean.x();
  const double turn_rad = step.theta_rad * (1.0 + mean.y()) + step.x_m * mean.z();
  return {longer * step.x_m, longer * step.y_m,
          turn_by_gyro ? step.theta_rad : normalize_angle(turn_rad)};
}

Eigen::Matrix3d OdometryBias::derivative(const Pose2& step, double theta_rad, bool turn_by_gyro) {
  Eigen::Matrix3d by = Eigen::Matrix3d::Zero();
  by.col(0).head<2>() = Eigen::Rotation2Dd(theta_rad) * step.translation_m();
  if (turn_by_gyro) return by;
  by(2, 1) = step.theta_rad;
  by(2, 2) = step.x_m;
  return by;
}

void OdometryBias::forget(double way_m) {
  covariance += way_m * variances(kScalePerM, kTurnPerMPerM);
}

void OdometryBias::add(const Eigen::Vector3d& correction) {
  const Eigen::Array3d most(kMostScale, kMostScale, kMostTurnPerM);
  mean = (mean + correction).array().max(-most).min(most);
}

}  // namespace marco::slam
