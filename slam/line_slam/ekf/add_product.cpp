#include "slam/line_slam/ekf/add_product.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace marco::slam {
namespace {

using Eigen::Index;

constexpr Index kRows = 8;     // of C at a time, as many sums as fit the registers
constexpr Index kColumns = 4;  // of C at a time
constexpr Index kPanelsInPlace = 2;
constexpr Index kDepth = 256;  // columns of A and B at a time: panels that stay in the first cache

using Sums = std::array<double, kRows * kColumns>;

// Sums of kRows x kColumns products over `depth`, by vectors of `kWide` numbers.
template <int kWide, int kParts>
[[gnu::always_inline]] inline void sum_panels(
    const double* a, Index a_step, const double* b, Index depth, double* sums) {
  typedef double Wide __attribute__((vector_size(kWide * sizeof(double)), aligned(8), may_alias));
  Wide sum[kParts][kColumns] = {};
  for (Index k = 0; k < depth; ++k, a += a_step, b += kColumns) {
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
void sum_narrow(const double* a, Index a_step, const double* b, Index depth, double* sums) {
  sum_panels<2, 2>(a, a_step, b, depth, sums);
  sum_panels<2, 2>(a + kRows / 2, a_step, b, depth, sums + kRows / 2);
}

#if defined(__x86_64__)
__attribute__((target("avx"))) void sum_wide(
    const double* a, Index a_step, const double* b, Index depth, double* sums) {
  sum_panels<4, 2>(a, a_step, b, depth, sums);
}
#endif

using SumPanels = void (*)(const double*, Index, const double*, Index, double*);

SumPanels choose() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx") != 0) return sum_wide;
#endif
  return sum_narrow;
}

// Rows of a panel beside each other, zeros below those that are there.
void pack(const ConstMatrixPart& from, Index rows, double* to) {
  for (Index k = 0; k < from.cols(); ++k, to += rows) {
    const double* column = from.data() + k * from.outerStride();
    std::copy(column, column + from.rows(), to);
    std::fill(to + from.rows(), to + rows, 0.0);
  }
}

void add_sums(double sign, const Sums& sums, MatrixPart& c, Index row, Index column) {
  const Index rows = std::min(kRows, c.rows() - row);
  const Index columns = std::min(kColumns, c.cols() - column);
  for (Index j = 0; j < columns; ++j) {
    double* to = c.data() + (column + j) * c.outerStride() + row;
    for (Index i = 0; i < rows; ++i) to[i] += sign * sums[static_cast<std::size_t>(j * kRows + i)];
  }
}

void add(
    double sign, const ConstMatrixPart& a, const ConstMatrixPart& b, bool lower, MatrixPart& c) {
  static const SumPanels kSumPanels = choose();
  const Index panels = (c.cols() + kColumns - 1) / kColumns;
  std::vector<double> right(
      static_cast<std::size_t>(panels * kColumns * std::min(kDepth, a.cols())));
  alignas(32) std::array<double, kRows * kDepth> left;
  alignas(32) Sums sums;
  for (Index first = 0; first < a.cols(); first += kDepth) {
    const Index depth = std::min(kDepth, a.cols() - first);
    for (Index column = 0; column < c.cols(); column += kColumns) {
      const Index columns = std::min(kColumns, b.rows() - column);
      pack(b.block(column, first, columns, depth), kColumns, right.data() + column * depth);
    }
    for (Index row = 0; row < c.rows(); row += kRows) {
      const Index rows = std::min(kRows, c.rows() - row);
      const Index end = lower ? std::min(c.cols(), row + kRows) : c.cols();
      // Few columns do not pay for a copy.
      const bool in_place = panels <= kPanelsInPlace && rows == kRows;
      const double* from = in_place ? a.data() + first * a.outerStride() + row : left.data();
      const Index from_step = in_place ? a.outerStride() : kRows;
      if (!in_place) pack(a.block(row, first, rows, depth), kRows, left.data());
      for (Index column = 0; column < end; column += kColumns) {
        kSumPanels(from, from_step, right.data() + column * depth, depth, sums.data());
        add_sums(sign, sums, c, row, column);
      }
    }
  }
}

}  // namespace

void add_product(double sign, const ConstMatrixPart& a, const ConstMatrixPart& b, MatrixPart c) {
  add(sign, a, b, false, c);
}

void add_square_to_lower(double sign, const ConstMatrixPart& a, MatrixPart c) {
  add(sign, a, a, true, c);
}

}  // namespace marco::slam
