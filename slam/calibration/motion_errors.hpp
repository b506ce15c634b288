#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/calibration/robot_model.hpp"

namespace marco::slam {

/// error_of() of each motion.
using Errors = std::vector<Eigen::Vector3d>;
Errors errors_of(const std::vector<MotionSample>& samples, const RobotModel& model);

/// Standard deviations along each axis by the median: outliers do not count. @param errors  some
Eigen::Vector3d spread_of(const Errors& errors);

double chi2_of(const Eigen::Vector3d& error, const Eigen::Vector3d& sigma);

/// A motion's weight by chi2_of(); 1 unless its error is beyond what noise does (dynamic covariance
/// scaling, Agarwal et al. 2013, from the 99 % quantile on).
double weight_of(double chi2);
/// The cost whose derivative weight_of() is.
double cost_of(double chi2);

/// How many errors count as one where neighbours are alike: 1 + 2 (sum of the autocorrelation).
double likeness(const Errors& errors, const Eigen::Vector3d& sigma);

/// Mean cost_of() of motions.
double squared_error(const std::vector<MotionSample>& samples,
                     const RobotModel& model,
                     const Eigen::Vector3d& sigma);

}  // namespace marco::slam
