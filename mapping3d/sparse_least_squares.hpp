#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace marco::mapping3d {

/// One linearized residual in a few of many unknowns: residual + sum of factors times changes.
struct Equation {
  static constexpr std::size_t kMost = 18;
  std::array<uint32_t, kMost> unknowns;
  std::array<float, kMost> factors;
  uint32_t count = 0;  ///< of the unknowns it depends on; the rest of the arrays is not read
  float residual = 0.0F;
  float weight = 0.0F;

  /// Each unknown once, kMost in all.
  void add(std::size_t unknown, double factor) {
    unknowns[count] = static_cast<uint32_t>(unknown);
    factors[count++] = static_cast<float>(factor);
  }
  /// What a step adds to the residual.
  double change(const Eigen::VectorXd& step) const {
    double sum = 0.0;
    for (uint32_t i = 0; i < count; ++i) sum += static_cast<double>(factors[i]) * step[unknowns[i]];
    return sum;
  }
};

/// The step that minimizes the weighted sum of squares: Eigen's conjugate gradients for least
/// squares (Jacobi preconditioner) to 1e-3 of the first gradient or 400 iterations. Unknowns
/// without equations stay at zero. Cost per iteration O(equations).
Eigen::VectorXd solve(const std::vector<Equation>& equations, Eigen::Index unknowns);

/// Part of the weighted sum of squares that a step removes.
double explained(const std::vector<Equation>& equations, const Eigen::VectorXd& step);

}  // namespace marco::mapping3d
