#include "mapping3d/sparse_least_squares.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <cmath>

namespace marco::mapping3d {

Eigen::VectorXd solve(const std::vector<Equation>& equations, Eigen::Index unknowns) {
  constexpr int kMaxIterations = 400;
  constexpr double kTolerance = 1e-3;  // Gauss-Newton relinearizes anyway
  const auto count = static_cast<Eigen::Index>(equations.size());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(equations.size() * Equation::kMost);
  Eigen::VectorXd right(count);
  for (Eigen::Index row = 0; row < count; ++row) {
    const Equation& equation = equations[static_cast<std::size_t>(row)];
    const double weight = std::sqrt(static_cast<double>(equation.weight));
    right[row] = -weight * static_cast<double>(equation.residual);
    for (uint32_t i = 0; i < equation.count; ++i) {
      entries.emplace_back(row, equation.unknowns[i],
                           weight * static_cast<double>(equation.factors[i]));
    }
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> jacobian(count, unknowns);
  jacobian.setFromTriplets(entries.begin(), entries.end());
  Eigen::LeastSquaresConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>> solver;
  solver.setMaxIterations(kMaxIterations);
  solver.setTolerance(kTolerance);
  return solver.compute(jacobian).solve(right);
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
