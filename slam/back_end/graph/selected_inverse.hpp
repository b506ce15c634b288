#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

namespace marco::slam {

using SparseSolver = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>;

/// Marginal covariances: the entries of a sparse symmetric positive matrix's inverse where the
/// matrix itself, or its factor, has entries: all that covariances of measured pairs need, at about
/// the cost of the factorization (Takahashi, Fagan & Chin 1973: Z = D^-1 L^-1 + (1 - L^T) Z, from
/// the last column on).
class SelectedInverse {
 public:
  /// @param solver  factorized, info() == Success; not needed afterwards.
  explicit SelectedInverse(const SparseSolver& solver);

  /// Entry (row, column) of the inverse, in the matrix's own order.
  /// @throws std::out_of_range where the factor has no entry.
  double at(Eigen::Index row, Eigen::Index column) const;

 private:
  std::size_t place(int row, int column) const;

  std::vector<int> ordered_;        ///< place of each row in the factor's order
  std::vector<int> starts_, rows_;  ///< the factor's pattern below the diagonal, by column
  std::vector<double> below_, diagonal_;
};

}  // namespace marco::slam
