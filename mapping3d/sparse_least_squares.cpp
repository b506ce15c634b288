#include "mapping3d/sparse_least_squares.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <cmath>

namespace marco::mapping3d {

Eigen::VectorXd solve(const std::vector<Equation>& equations, Eigen::Index unknowns) {
  constexpr int kMaxIterations = 400;  // against hanging
  constexpr double kTolerance = 1e-3;  // Gauss-Newton relinearizes anyway
  using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  const auto count = static_cast<Eigen::Index>(equations.size());
  std::vector<int> starts{0}, columns;
  std::vector<double> values;
  Eigen::VectorXd right(count);
  for (const Equation& equation : equations) {
    const double weight = std::sqrt(static_cast<double>(equation.weight));
    right[static_cast<Eigen::Index>(starts.size()) - 1] =
        -weight * static_cast<double>(equation.residual);
    for (uint32_t i = 0; i < equation.count; ++i) {
      columns.push_back(static_cast<int>(equation.unknowns[i]));
      values.push_back(weight * static_cast<double>(equation.factors[i]));
    }
    starts.push_back(static_cast<int>(columns.size()));
  }
  const Eigen::Map<const Matrix> jacobian(count, unknowns, static_cast<Eigen::Index>(values.size()),
                                          starts.data(), columns.data(), values.data());
  Eigen::LeastSquaresConjugateGradient<Matrix> solver;
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
