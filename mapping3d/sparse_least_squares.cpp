#include "mapping3d/sparse_least_squares.hpp"

#include <cmath>

namespace marco::mapping3d {

Eigen::VectorXd solve(const std::vector<Equation>& equations, Eigen::Index unknowns) {
  constexpr int kMostSteps = 400;
  constexpr double kEnough = 1e-3;  // of the first gradient; the next linearization does the rest
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(unknowns, 1e-9);
  Eigen::VectorXd rest = Eigen::VectorXd::Zero(unknowns);
  for (const Equation& equation : equations) {
    const auto weight = static_cast<double>(equation.weight);
    equation.spread(-weight * static_cast<double>(equation.residual), rest);
    for (uint32_t i = 0; i < equation.count; ++i) {
      const auto factor = static_cast<double>(equation.factors[i]);
      diagonal[equation.unknowns[i]] += weight * factor * factor;
    }
  }
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
  Eigen::VectorXd scaled = rest.cwiseQuotient(diagonal);
  Eigen::VectorXd direction = scaled, image(unknowns);
  double energy = rest.dot(scaled);
  const double enough = kEnough * kEnough * energy;
  for (int step = 0; step < kMostSteps && energy > enough; ++step) {
    image = 1e-9 * direction;
    for (const Equation& equation : equations) {
      equation.spread(static_cast<double>(equation.weight) * equation.change(direction), image);
    }
    const double length = energy / direction.dot(image);
    x += length * direction;
    rest -= length * image;
    scaled = rest.cwiseQuotient(diagonal);
    const double next = rest.dot(scaled);
    direction = scaled + (next / energy) * direction;
    energy = next;
  }
  return x;
}

double explained(const std::vector<Equation>& equations, const Eigen::VectorXd& step) {
  double before = 0.0, after = 0.0;
  for (const Equation& equation : equations) {
    const auto residual = static_cast<double>(equation.residual);
    const auto weight = static_cast<double>(equation.weight);
    before += weight * residual * residual;
    after += weight * std::pow(residual + equation.change(step), 2);
  }
  return before > 0.0 ? 1.0 - after / before : 0.0;
}

}  // namespace marco::mapping3d
