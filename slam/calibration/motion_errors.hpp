#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/calibration/robot_model.hpp"

namespace marco::slam {

/// error_of() of each motion.
using Errors = std::vector<Eigen::Vector3d>;
Errors errors_of(const std::vector<MotionSample>& samples, const RobotModel& model);

/// Standard deviations of error_of(), in m, m and rad: of motions that do not turn, and what a turn
/// adds to their squares. Wheels slip by a part of the turn, and no sample says when it began. With
/// one spread for all motions, the few turns of a mostly straight drive would be outliers.
struct ErrorSpread {
  Eigen::Vector3d straight = Eigen::Vector3d::Ones();
  Eigen::Vector3d of_turn = Eigen::Vector3d::Zero();  ///< for a turn of the laser by one radian

  Eigen::Vector3d of(const MotionSample& sample) const;
};

/// By medians: outliers do not count. @param errors  of the samples
ErrorSpread spread_of(const std::vector<MotionSample>& samples, const Errors& errors);

/// Each error in units of its spread.
Errors normalized(const std::vector<MotionSample>& samples,
                  Errors errors,
                  const ErrorSpread& spread);

/// A motion's weight by its normalized error's square; 1 unless its error is beyond what noise does
/// (dynamic covariance scaling, Agarwal et al. 2013, from the 99 % quantile on).
double weight_of(double chi2);
/// The cost whose derivative weight_of() is.
double cost_of(double chi2);

/// How many errors count as one where neighbours are alike: 1 + 2 (sum of the autocorrelation).
double likeness(const Errors& normalized_errors);

/// Mean cost_of() of motions.
double squared_error(const std::vector<MotionSample>& samples,
                     const RobotModel& model,
                     const ErrorSpread& spread);

}  // namespace marco::slam
