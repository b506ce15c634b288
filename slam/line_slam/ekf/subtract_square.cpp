#include "slam/line_slam/ekf/subtract_square.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace marco::slam {
namespace {

using Eigen::Index;

constexpr Index kRows = 8;     // of P at a time, as many sums as fit the registers
constexpr Index kColumns = 4;  // of P at a time

using Sums = std::array<double, kRows * kColumns>;

// Sums over `depth` of kWide * kParts rows of one panel times kColumns rows of another.
template <int kWide, int kParts>
[[gnu::always_inline]] inline void sum_rows(const double* a,
                                            const double* b,
                                            Index depth,
                                            double* sums) {
  typedef double Wide __attribute__((vector_size(kWide * sizeof(double)), aligned(8), may_alias));
  Wide sum[kParts][kColumns] = {};
  for (Index k = 0; k < depth; ++k, a += kRows, b += kRows) {
    for (int part = 0; part < kParts; ++part) {
      const Wide left = *reinterpret_cast<const Wide*>(a + Index{part} * kWide);
      for (int column = 0; column < kColumns; ++column) sum[part][column] += left * b[column];
    }
  }
  for (int part = 0; part < kParts; ++part) {
    for (int column = 0; column < kColumns; ++column) {
      *reinterpret_cast<Wide*>(sums + Index{column} * kRows + Index{part} * kWide) =
          sum[part][column];
    }
  }
}

// In two halves: eight sums of two numbers fill the registers every processor has.
void sum_narrow(const double* a, const double* b, Index depth, double* sums) {
  sum_rows<2, 2>(a, b, depth, sums);
  sum_rows<2, 2>(a + kRows / 2, b, depth, sums + kRows / 2);
}

#if defined(__x86_64__)
__attribute__((target("avx"))) void sum_wide(const double* a,
                                             const double* b,
                                             Index depth,
                                             double* sums) {
  sum_rows<4, 2>(a, b, depth, sums);
}
#endif

using SumRows = void (*)(const double*, const double*, Index, double*);

SumRows choose() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx") != 0) return sum_wide;
#endif
  return sum_narrow;
}

// Panels of kRows rows, a column after the other, zeros below the last row.
std::vector<double> panels_of(const Eigen::Ref<const Eigen::MatrixXd>& u) {
  const Index panels = (u.rows() + kRows - 1) / kRows;
  std::vector<double> packed(static_cast<std::size_t>(panels * kRows * u.cols()));
  for (Index row = 0; row < u.rows(); ++row) {
    double* to = packed.data() + row / kRows * kRows * u.cols() + row % kRows;
    for (Index k = 0; k < u.cols(); ++k) to[k * kRows] = u(row, k);
  }
  return packed;
}

}  // namespace

void subtract_square(const Eigen::Ref<const Eigen::MatrixXd>& u, Eigen::MatrixXd& p) {
  static const SumRows kSumRows = choose();
  const Index n = u.rows(), depth = u.cols();
  const std::vector<double> packed = panels_of(u);
  Sums sums;
  for (Index column = 0; column < n; column += kColumns) {
    const double* right = packed.data() + column / kRows * kRows * depth + column % kRows;
    for (Index row = column / kRows * kRows; row < n; row += kRows) {
      kSumRows(packed.data() + row * depth, right, depth, sums.data());
      for (Index j = 0; j < std::min(kColumns, n - column); ++j) {
        double* to = &p(row, column + j);
        const double* from = sums.data() + j * kRows;
        for (Index i = 0; i < std::min(kRows, n - row); ++i) to[i] -= from[i];
      }
    }
  }
}

}  // namespace marco::slam
