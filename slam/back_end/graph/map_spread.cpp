#include "slam/back_end/graph/map_spread.hpp"

#include <algorithm>
#include <limits>
#include <random>

#include "common/rigid_fit.hpp"
#include "slam/back_end/graph/selected_inverse.hpp"
#include "slam/back_end/graph/sparse_normal_equations.hpp"

namespace marco::slam {
namespace {

constexpr int kDrawings = 32;  // their median is known to 22 % of the spread between them

double quantile(std::vector<double>& values, double part) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

double map_spread_m(const PoseGraph& graph, const std::vector<double>& weights, double part) {
  SparseNormalEquations equations(graph.node_count());
  graph.fill(equations, weights, Moves::poses);
  const SparseSolver solver(equations.hessian());
  if (solver.info() != Eigen::Success || solver.vectorD().minCoeff() <= 0.0)
    return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd roots = solver.vectorD().cwiseSqrt().cwiseInverse();
  Eigen::Matrix2Xd ours(2, graph.node_count());
  for (std::size_t i = 0; i < graph.node_count(); ++i)
    ours.col(static_cast<Eigen::Index>(i)) = graph.poses()[i].translation_m();
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<double> spreads;
  for (int drawing = 0; drawing < kDrawings; ++drawing) {
    Eigen::VectorXd z(roots.size());
    for (double& value : z) value = normal(random);
    const Eigen::VectorXd step =
        solver.permutationPinv() * solver.matrixU().solve(roots.cwiseProduct(z));
    Eigen::Matrix2Xd drawn = ours;
    for (Eigen::Index i = 1; i < ours.cols(); ++i) drawn.col(i) += step.segment<2>(3 * (i - 1));
    const Eigen::VectorXd distances = distances_after_fit(drawn, ours);
    std::vector<double> values(distances.begin(), distances.end());
    spreads.push_back(quantile(values, 1.0 - part));
  }
  return quantile(spreads, 0.5);
}

}  // namespace marco::slam
