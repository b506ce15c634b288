#include "slam/calibration/gyro_fit.hpp"

#include <algorithm>
#include <cmath>

#include "common/linear_algebra.hpp"
#include "common/median.hpp"

namespace marco::slam {
namespace {

// Scale, scale times bias, lateness: the first two are linear.
using Parameters = Eigen::Vector3d;

double counted(const LaserMotion& motion, const OdometryTravel& travel, double late_s) {
  return travel.between_moments(motion.begin_s + late_s, motion.end_s + late_s).turn_rad;
}

double error_at(const LaserMotion& motion, const OdometryTravel& travel, const Parameters& at) {
  return motion.moved.theta_rad - at[0] * counted(motion, travel, at[2]) +
         at[1] * (motion.end_s - motion.begin_s);
}

double spread_at(const std::vector<LaserMotion>& motions,
                 const OdometryTravel& travel,
                 const Parameters& at) {
  constexpr double kLeastRad = 1e-5;  // of a motion without any noise, as in a simulation
  std::vector<double> sizes;
  for (const LaserMotion& motion : motions) {
    sizes.push_back(std::abs(error_at(motion, travel, at)));
  }
  return std::max(kSigmaOfMedian * median(std::move(sizes)), kLeastRad);
}

// Weak knowledge keeps what cannot be observed where it is.
NormalEquations<3> equations_at(const std::vector<LaserMotion>& motions,
                                const OdometryTravel& travel,
                                const Parameters& at) {
  constexpr double kStepS = 0.01;  // of the difference quotient by the lateness
  constexpr double kSigmas = 3.0;  // farther off counts less: a wrong match of scans
  const double sigma = spread_at(motions, travel, at);
  NormalEquations<3> sum;
  for (const LaserMotion& motion : motions) {
    const double error = error_at(motion, travel, at);
    const double by_time =
        (counted(motion, travel, at[2] + kStepS) - counted(motion, travel, at[2] - kStepS)) /
        (2.0 * kStepS);
    const Eigen::Vector3d row(-counted(motion, travel, at[2]), motion.end_s - motion.begin_s,
                              -at[0] * by_time);
    const double far = std::max(1.0, std::abs(error) / (kSigmas * sigma));
    sum.add(row, error, 1.0 / (sigma * sigma * far * far * far * far));
  }
  sum.information.diagonal() += Eigen::Vector3d(0.0, 1.0, 1.0);
  return sum;
}

Parameters fitted(const std::vector<LaserMotion>& motions,
                  const OdometryTravel& travel,
                  Parameters at) {
  constexpr int kIterations = 10;  // of three parameters, from a start by correlation
  constexpr double kFarS = 0.02;   // a step of the lateness: its derivative is local
  for (int i = 0; i < kIterations; ++i) {
    Parameters step = equations_at(motions, travel, at).step();
    step[2] = std::clamp(step[2], -kFarS, kFarS);
    at += step;
  }
  return at;
}

// Mean square, none counting for more than 3 standard deviations.
double squared_error(const std::vector<LaserMotion>& motions,
                     const OdometryTravel& travel,
                     const Parameters& at,
                     double sigma) {
  double sum = 0.0;
  for (const LaserMotion& motion : motions) {
    const double error = error_at(motion, travel, at) / sigma;
    sum += std::min(error * error, 9.0);
  }
  return sum;
}

// Cross-validation in kFolds folds: a drive has few turns, and a single fold may hold none of them.
std::array<bool, 3> better_by(const std::vector<LaserMotion>& motions,
                              const OdometryTravel& travel,
                              const Parameters& start) {
  double error = 0.0;
  std::array<double, 3> error_without{};
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    const auto [seen, held_out] = split(motions, fold);
    if (seen.empty() || held_out.empty()) continue;
    const Parameters blind = fitted(seen, travel, start);
    const double sigma = spread_at(seen, travel, blind);
    error += squared_error(held_out, travel, blind, sigma);
    const std::array<Parameters, 3> without{Parameters(1.0, blind[1], blind[2]),
                                            Parameters(blind[0], 0.0, blind[2]),
                                            Parameters(blind[0], blind[1], 0.0)};
    for (std::size_t i = 0; i < without.size(); ++i) {
      error_without[i] += squared_error(held_out, travel, without[i], sigma);
    }
  }
  std::array<bool, 3> better{};
  for (std::size_t i = 0; i < better.size(); ++i) better[i] = error_without[i] > error;
  return better;
}

}  // namespace

GyroFit fit_gyro(const std::vector<LaserMotion>& motions, const OdometryTravel& travel) {
  GyroFit fit;
  fit.turns = correlate_turns(motions, travel);
  if (fit.turns.slope == 0.0) return fit;
  const Parameters at = fitted(motions, travel, Parameters(fit.turns.slope, 0.0, fit.turns.late_s));
  const Eigen::Matrix3d covariance = inverse_of(equations_at(motions, travel, at).information);
  fit.found = {at[0], at[1] / at[0], at[2]};
  const Eigen::Vector3d bias_row(-fit.found.bias_rad_per_s / at[0], 1.0 / at[0], 0.0);
  fit.sigma = {std::sqrt(covariance(0, 0)), std::sqrt(bias_row.dot(covariance * bias_row)),
               std::sqrt(covariance(2, 2))};
  fit.better = better_by(motions, travel, at);
  return fit;
}

}  // namespace marco::slam
