#include "slam/back_end/graph/selected_inverse.hpp"

#include <algorithm>
#include <stdexcept>

namespace marco::slam {

SelectedInverse::SelectedInverse(const SparseSolver& solver) {
  const Eigen::SparseMatrix<double>& factor = solver.matrixL().nestedExpression();
  const auto size = static_cast<std::size_t>(factor.cols());
  const auto& order = solver.permutationP().indices();
  for (std::size_t i = 0; i < size; ++i) {
    ordered_.push_back(order.size() > 0 ? order[static_cast<Eigen::Index>(i)]
                                        : static_cast<int>(i));
  }
  std::vector<double> of_factor;
  starts_.push_back(0);
  for (Eigen::Index column = 0; column < factor.cols(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(factor, column); entry; ++entry) {
      if (entry.row() <= column) continue;
      rows_.push_back(static_cast<int>(entry.row()));
      of_factor.push_back(entry.value());
    }
    starts_.push_back(static_cast<int>(rows_.size()));
  }
  below_.resize(rows_.size());
  diagonal_.resize(size);
  for (auto column = static_cast<int>(size); column-- > 0;) {
    const auto first = static_cast<std::size_t>(starts_[static_cast<std::size_t>(column)]);
    const auto last = static_cast<std::size_t>(starts_[static_cast<std::size_t>(column) + 1]);
    double on_diagonal = 1.0 / solver.vectorD()[column];
    for (std::size_t i = last; i-- > first;) {
      double sum = 0.0;
      for (std::size_t k = first; k < last; ++k) {
        const double known =
            i == k ? diagonal_[static_cast<std::size_t>(rows_[i])]
                   : below_[place(std::max(rows_[i], rows_[k]), std::min(rows_[i], rows_[k]))];
        sum -= of_factor[k] * known;
      }
      below_[i] = sum;
      on_diagonal -= of_factor[i] * sum;
    }
    diagonal_[static_cast<std::size_t>(column)] = on_diagonal;
  }
}

std::size_t SelectedInverse::place(int row, int column) const {
  const auto first = rows_.begin() + starts_[static_cast<std::size_t>(column)];
  const auto last = rows_.begin() + starts_[static_cast<std::size_t>(column) + 1];
  const auto found = std::lower_bound(first, last, row);
  if (found == last || *found != row) throw std::out_of_range("SelectedInverse: no such entry");
  return static_cast<std::size_t>(found - rows_.begin());
}

double SelectedInverse::at(Eigen::Index row, Eigen::Index column) const {
  const int a = ordered_.at(static_cast<std::size_t>(row));
  const int b = ordered_.at(static_cast<std::size_t>(column));
  if (a == b) return diagonal_[static_cast<std::size_t>(a)];
  return below_[place(std::max(a, b), std::min(a, b))];
}

}  // namespace marco::slam
