#include "slam/calibration/motion_errors.hpp"

#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"
#include "common/median.hpp"

namespace marco::slam {

Errors errors_of(const std::vector<MotionSample>& samples, const RobotModel& model) {
  Errors errors;
  errors.reserve(samples.size());
  for (const MotionSample& sample : samples) errors.push_back(error_of(sample, model));
  return errors;
}

Eigen::Vector3d ErrorSpread::of(const MotionSample& sample) const {
  const double turn_rad = std::abs(sample.laser_moved.theta_rad);
  return (straight.array().square() + (turn_rad * of_turn).array().square()).sqrt();
}

ErrorSpread spread_of(const std::vector<MotionSample>& samples, const Errors& errors) {
  constexpr double kLeastM = 1e-5, kLeastRad = 1e-5;  // of motions without any noise
  constexpr double kTurnDeg = 3.0;                    // many times the noise of a match
  std::vector<double> turns_rad;
  for (const MotionSample& sample : samples) {
    turns_rad.push_back(std::abs(sample.laser_moved.theta_rad));
  }
  // Where all motions turn, the half that turns least.
  const double most_rad = std::max(deg_to_rad(kTurnDeg), median(turns_rad));
  ErrorSpread spread;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> sizes, excesses;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (turns_rad[i] <= most_rad) sizes.push_back(std::abs(errors[i][axis]));
    }
    const double sigma =
        std::max(kSigmaOfMedian * median(std::move(sizes)), axis < 2 ? kLeastM : kLeastRad);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (turns_rad[i] <= most_rad) continue;
      const double size = kSigmaOfMedian * std::abs(errors[i][axis]);
      excesses.push_back(std::sqrt(std::max(0.0, size * size - sigma * sigma)) / turns_rad[i]);
    }
    spread.straight[axis] = sigma;
    spread.of_turn[axis] = median(std::move(excesses));
  }
  return spread;
}

Errors normalized(const std::vector<MotionSample>& samples,
                  Errors errors,
                  const ErrorSpread& spread) {
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i] = errors[i].cwiseQuotient(spread.of(samples[i]));
  }
  return errors;
}

double weight_of(double chi2) {
  const double s = std::min(1.0, 2.0 * kChi2Dof3Quantile99 / (kChi2Dof3Quantile99 + chi2));
  return s * s;
}

double cost_of(double chi2) {
  constexpr double kLimit = kChi2Dof3Quantile99;
  return chi2 <= kLimit ? chi2 : 3.0 * kLimit - 4.0 * kLimit * kLimit / (kLimit + chi2);
}

double likeness(const Errors& errors) {
  constexpr std::size_t kLongestLag = 10;  // motions: 5 to 15 s, in which scans share a local map
  double sum = 1.0;
  for (std::size_t lag = 1; lag <= kLongestLag && 4 * lag < errors.size(); ++lag) {
    double product = 0.0, square = 0.0;
    for (std::size_t i = lag; i < errors.size(); ++i) {
      const double chi2 = errors[i].squaredNorm();
      const double weight = std::sqrt(weight_of(chi2) * weight_of(errors[i - lag].squaredNorm()));
      product += weight * errors[i].dot(errors[i - lag]);
      square += weight * chi2;
    }
    const double correlation = square > 0.0 ? product / square : 0.0;
    if (correlation < 2.0 / std::sqrt(static_cast<double>(errors.size()))) break;
    sum += 2.0 * correlation;
  }
  return sum;
}

double squared_error(const std::vector<MotionSample>& samples,
                     const RobotModel& model,
                     const ErrorSpread& spread) {
  double sum = 0.0;
  for (const Eigen::Vector3d& error : normalized(samples, errors_of(samples, model), spread)) {
    sum += cost_of(error.squaredNorm());
  }
  return sum / static_cast<double>(std::max<std::size_t>(samples.size(), 1));
}

}  // namespace marco::slam
