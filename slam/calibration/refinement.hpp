#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>

#include "slam/calibration/motion_errors.hpp"

namespace marco::slam {

/// What is refined together. The model's parameters as a vector, in this order.
enum ModelParameter { kLeftScale, kRightScale, kTrack, kLaserX, kLaserY, kLaserYaw, kLate };
inline constexpr int kModelParameters = 7;
using ModelVector = Eigen::Matrix<double, kModelParameters, 1>;
using ModelMatrix = Eigen::Matrix<double, kModelParameters, kModelParameters>;

ModelVector to_vector(const RobotModel& model, double late_s);
RobotModel to_model(const ModelVector& parameters);

/// What was believed before.
struct ModelPrior {
  ModelVector mean = ModelVector::Zero();
  ModelVector sigma = ModelVector::Ones();
};

/// The same motions each time, by wheels that are taken to be so late.
using SamplesAt = std::function<std::vector<MotionSample>(double late_s)>;

struct RefinedModel {
  ModelVector parameters = ModelVector::Zero();
  ModelMatrix covariance = ModelMatrix::Zero();  ///< parameters that cannot be observed included
  std::array<bool, kModelParameters> observed{};
  ErrorSpread spread;
  double unlikeliness = 0.0;  ///< -2 log of the likelihood, but for a constant
};

/// Least squares over all parameters: Gauss-Newton with derivatives by central differences, robust
/// (weight_of()), errors weighed by their own spread. What the motions do not hold keeps its prior
/// mean, and is not `observed`: there the posterior's standard deviation is more than half the
/// prior's, turns and ways that noise explains counting as none. Neighbouring errors that are alike
/// widen the covariance.
RefinedModel refine(const SamplesAt& samples_at, const ModelVector& start, const ModelPrior& prior);

}  // namespace marco::slam
