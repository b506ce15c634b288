#pragma once

#include <Eigen/Core>

namespace marco::slam {

using ConstMatrixPart = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using MatrixPart = Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// C += sign A B^T, the one product of large matrices that the filter needs: for C of some hundred
/// rows and few columns, and with the processor's wide registers where it has them. Every entry is
/// summed in one order without fused multiply-add, so that all machines get the same bits.
/// @param a  n x k. @param b  m x k. @param c  n x m; must not overlap a or b.
void add_product(double sign, const ConstMatrixPart& a, const ConstMatrixPart& b, MatrixPart c);

/// The lower half (with the diagonal) of C += sign A A^T, C square; what stands above the diagonal
/// is meaningless afterwards.
void add_square_to_lower(double sign, const ConstMatrixPart& a, MatrixPart c);

}  // namespace marco::slam
