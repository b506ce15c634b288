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

Eigen::Vector3d spread_of(const Errors& errors) {
  constexpr double kLeastM = 1e-5, kLeastRad = 1e-5;  // of motions without any noise
  Eigen::Vector3d sigma;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> sizes;
    for (const Eigen::Vector3d& error : errors) sizes.push_back(std::abs(error[axis]));
    sigma[axis] =
        std::max(kSigmaOfMedian * median(std::move(sizes)), axis < 2 ? kLeastM : kLeastRad);
  }
  return sigma;
}

double chi2_of(const Eigen::Vector3d& error, const Eigen::Vector3d& sigma) {
  return error.cwiseQuotient(sigma).squaredNorm();
}

double weight_of(double chi2) {
  const double s = std::min(1.0, 2.0 * kChi2Dof3Quantile99 / (kChi2Dof3Quantile99 + chi2));
  return s * s;
}

double cost_of(double chi2) {
  constexpr double kLimit = kChi2Dof3Quantile99;
  return chi2 <= kLimit ? chi2 : 3.0 * kLimit - 4.0 * kLimit * kLimit / (kLimit + chi2);
}

double likeness(const Errors& errors, const Eigen::Vector3d& sigma) {
  constexpr std::size_t kLongestLag = 10;  // motions: 5 to 15 s, in which scans share a local map
  double sum = 1.0;
  for (std::size_t lag = 1; lag <= kLongestLag && 4 * lag < errors.size(); ++lag) {
    double product = 0.0, square = 0.0;
    for (std::size_t i = lag; i < errors.size(); ++i) {
      const double weight = std::sqrt(weight_of(chi2_of(errors[i], sigma)) *
                                      weight_of(chi2_of(errors[i - lag], sigma)));
      product += weight * errors[i].cwiseQuotient(sigma).dot(errors[i - lag].cwiseQuotient(sigma));
      square += weight * chi2_of(errors[i], sigma);
    }
    const double correlation = square > 0.0 ? product / square : 0.0;
    if (correlation < 2.0 / std::sqrt(static_cast<double>(errors.size()))) break;
    sum += 2.0 * correlation;
  }
  return sum;
}

double squared_error(const std::vector<MotionSample>& samples,
                     const RobotModel& model,
                     const Eigen::Vector3d& sigma) {
  double sum = 0.0;
  for (const MotionSample& sample : samples) {
    sum += cost_of(chi2_of(error_of(sample, model), sigma));
  }
  return sum / static_cast<double>(std::max<std::size_t>(samples.size(), 1));
}

}  // namespace marco::slam
