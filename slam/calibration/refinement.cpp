#include "slam/calibration/refinement.hpp"

#include <algorithm>
#include <cmath>

#include "common/input/sensor_calibration.hpp"
#include "common/linear_algebra.hpp"

namespace marco::slam {
namespace {

using Jacobian = Eigen::Matrix<double, 3, kModelParameters>;

std::vector<Jacobian> jacobians(const SamplesAt& samples_at, const ModelVector& at) {
  ModelVector steps;
  steps << 1e-4 * std::max(0.01, std::abs(at[kLeftScale])),
      1e-4 * std::max(0.01, std::abs(at[kRightScale])), 1e-4 * at[kTrack], 1e-4, 1e-4, 1e-4, 1e-2;
  const std::vector<MotionSample> samples = samples_at(at[kLate]);
  std::vector<Jacobian> result(samples.size());
  for (int i = 0; i < kModelParameters; ++i) {
    ModelVector up = at, down = at;
    up[i] += steps[i];
    down[i] -= steps[i];
    const Errors above = errors_of(i == kLate ? samples_at(up[kLate]) : samples, to_model(up));
    const Errors below = errors_of(i == kLate ? samples_at(down[kLate]) : samples, to_model(down));
    for (std::size_t k = 0; k < result.size(); ++k) {
      Eigen::Vector3d change = above[k] - below[k];
      change.z() = normalize_angle(change.z());
      result[k].col(i) = change / (2.0 * steps[i]);
    }
  }
  return result;
}

// The same motions with a little more of each, spread over the steps.
std::vector<MotionSample> with_more(std::vector<MotionSample> samples,
                                    const RobotModel& model,
                                    const ArcMotion& more) {
  for (MotionSample& sample : samples) {
    const double part = 1.0 / static_cast<double>(sample.wheels.size());
    const double apart_m = 0.5 * model.track_m * more.turn_rad;
    for (WheelStep& step : sample.wheels) {
      step.left += part * (more.ahead_m - apart_m) / model.left_scale;
      step.right += part * (more.ahead_m + apart_m) / model.right_scale;
    }
  }
  return samples;
}

class Refinement {
 public:
  Refinement(const SamplesAt& samples_at, const ModelPrior& prior)
      : samples_at_(samples_at), prior_(prior) {
    free_.fill(true);
  }

  void hold(int parameter) {
    free_[static_cast<std::size_t>(parameter)] = false;
    at_[parameter] = prior_.mean[parameter];
  }

  void run(const ModelVector& start) {
    constexpr int kRounds = 4;  // spread and parameters depend on each other, weakly
    at_ = start;
    for (int i = 0; i < kModelParameters; ++i) {
      if (!free_[static_cast<std::size_t>(i)]) at_[i] = prior_.mean[i];
    }
    for (int i = 0; i < kRounds; ++i) {
      spread_ = spread_here();
      descend();
    }
    spread_ = spread_here();
  }

  ModelMatrix information() const {
    return equations_of(samples_at_).information / likeness(normalized_at(at_));
  }

  // What is left of it without what noise of the wheels' readings adds: a robot that goes straight
  // seems to turn a little. Errors in all directions add to the squares, which their own size
  // tells.
  ModelMatrix information_without_noise() const {
    constexpr double kSigmas = 2.0;  // 95 % of the readings are no farther off
    const RobotModel model = to_model(at_);
    const double more_m = kSigmas * spread_.straight.head<2>().maxCoeff();
    const double more_rad = kSigmas * spread_.straight.z();
    const ModelMatrix as_read = equations_of(samples_at_).information;
    ModelMatrix sum = as_read;
    for (const ArcMotion& more : {ArcMotion{more_m, 0, 0}, ArcMotion{-more_m, 0, 0},
                                  ArcMotion{0, 0, more_rad}, ArcMotion{0, 0, -more_rad}}) {
      const SamplesAt noisy = [&](double late_s) {
        return with_more(samples_at_(late_s), model, more);
      };
      sum += 0.5 * (as_read - equations_of(noisy).information);
    }
    // In units of the prior, negative eigenvalues are none.
    const auto sigma = prior_.sigma.asDiagonal();
    const ModelVector inverse = prior_.sigma.cwiseInverse();
    const ModelMatrix scaled = nonnegative_part(sigma * sum * sigma);
    return inverse.asDiagonal() * scaled * inverse.asDiagonal() / likeness(normalized_at(at_));
  }

  const ModelVector& at() const { return at_; }
  const ErrorSpread& spread() const { return spread_; }
  // The errors' spread is part of the fit: large errors that agree with a large spread are no
  // better than small ones.
  double unlikeliness() const {
    double sum = cost_at(at_);
    for (const MotionSample& sample : samples_at_(at_[kLate])) {
      sum += 2.0 * spread_.of(sample).array().log().sum();
    }
    return sum;
  }

 private:
  ErrorSpread spread_here() const {
    const std::vector<MotionSample> samples = samples_at_(at_[kLate]);
    return spread_of(samples, errors_of(samples, to_model(at_)));
  }
  Errors normalized_at(const ModelVector& at) const {
    const std::vector<MotionSample> samples = samples_at_(at[kLate]);
    return normalized(samples, errors_of(samples, to_model(at)), spread_);
  }

  using Equations = NormalEquations<kModelParameters>;
  // @param samples_at  whose derivatives count. @param sum  what is known without the motions
  Equations equations_of(const SamplesAt& samples_at, Equations sum = {}) const {
    const auto jacobian = jacobians(samples_at, at_);
    const std::vector<MotionSample> samples = samples_at_(at_[kLate]);
    const Errors errors = errors_of(samples, to_model(at_));
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const Eigen::Vector3d weights = weights_of(samples[i], errors[i]);
      sum.information += jacobian[i].transpose() * weights.asDiagonal() * jacobian[i];
      sum.gradient += jacobian[i].transpose() * weights.cwiseProduct(errors[i]);
    }
    return sum;
  }

  // Of an error's squares.
  Eigen::Vector3d weights_of(const MotionSample& sample, const Eigen::Vector3d& error) const {
    const Eigen::Vector3d sigma = spread_.of(sample);
    return weight_of(error.cwiseQuotient(sigma).squaredNorm()) * sigma.cwiseAbs2().cwiseInverse();
  }

  ModelVector prior_error(const ModelVector& at) const {
    ModelVector error = at - prior_.mean;
    error[kLaserYaw] = normalize_angle(error[kLaserYaw]);
    return error;
  }

  double cost_at(const ModelVector& at) const {
    double cost = prior_error(at).cwiseQuotient(prior_.sigma).squaredNorm();
    for (const Eigen::Vector3d& error : normalized_at(at)) cost += cost_of(error.squaredNorm());
    return cost;
  }

  void descend() {
    constexpr int kIterations = 15;      // against hanging
    constexpr double kConverged = 1e-4;  // of a standard deviation
    double damping = 1e-6;
    double cost = cost_at(at_);
    for (int i = 0; i < kIterations; ++i) {
      const ModelMatrix by_prior = prior_.sigma.cwiseAbs2().cwiseInverse().asDiagonal();
      const auto [normal, gradient] =
          equations_of(samples_at_, {by_prior, by_prior * prior_error(at_)});
      const ModelVector step = damped_step(normal, gradient, damping);
      const double next = cost_at(at_ + step);
      if (next <= cost) {
        at_ += step;
        cost = next;
        damping = std::max(0.1 * damping, 1e-9);
        if (step.dot(normal * step) < kConverged * kConverged) return;
      } else {
        damping *= 30.0;
      }
    }
  }

  ModelVector damped_step(ModelMatrix normal, ModelVector gradient, double damping) const {
    normal.diagonal() *= 1.0 + damping;
    for (int i = 0; i < kModelParameters; ++i) {
      if (free_[static_cast<std::size_t>(i)]) continue;
      normal.row(i).setZero();
      normal.col(i).setZero();
      normal(i, i) = 1.0;
      gradient[i] = 0.0;
    }
    return -solve_symmetric(normal, gradient);
  }

  const SamplesAt& samples_at_;
  const ModelPrior& prior_;
  std::array<bool, kModelParameters> free_{};
  ModelVector at_ = ModelVector::Zero();
  ErrorSpread spread_;
};

// @param information  of the motions alone
ModelMatrix with_prior(ModelMatrix information, const ModelPrior& prior) {
  information.diagonal() += prior.sigma.cwiseAbs2().cwiseInverse();
  return inverse_of(information);
}

}  // namespace

ModelVector to_vector(const RobotModel& model, double late_s) {
  const Pose2& laser = model.robot_from_laser;
  return (ModelVector() << model.left_scale, model.right_scale, model.track_m, laser.x_m, laser.y_m,
          laser.theta_rad, late_s)
      .finished();
}

RobotModel to_model(const ModelVector& parameters) {
  return {parameters[kLeftScale],
          parameters[kRightScale],
          parameters[kTrack],
          {parameters[kLaserX], parameters[kLaserY], normalize_angle(parameters[kLaserYaw])}};
}

RefinedModel refine(const SamplesAt& samples_at,
                    const ModelVector& start,
                    const ModelPrior& prior) {
  Refinement refinement(samples_at, prior);
  refinement.run(start);
  RefinedModel result;
  // All together with the prior first: it shows what is observable.
  result.covariance = with_prior(refinement.information_without_noise(), prior);
  for (int i = 0; i < kModelParameters; ++i) {
    const bool observed = std::sqrt(result.covariance(i, i)) <= 0.5 * prior.sigma[i];
    result.observed[static_cast<std::size_t>(i)] = observed;
    if (!observed) refinement.hold(i);
  }
  const bool all = std::all_of(result.observed.begin(), result.observed.end(),
                               [](bool observed) { return observed; });
  if (all) {
    result.covariance = with_prior(refinement.information(), prior);
  } else {
    refinement.run(refinement.at());
  }
  result.parameters = refinement.at();
  result.spread = refinement.spread();
  result.unlikeliness = refinement.unlikeliness();
  return result;
}

}  // namespace marco::slam
