#include "slam/matching/point_index.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// Limit of buckets per point: an outlier at 1 km must not cost a gigabyte.
constexpr double kCellsPerPoint = 64.0;
constexpr double kMinCells = 65536.0;

}  // namespace

PointIndex::PointIndex(const Points2& points, double cell_m) : points_(points), cell_m_(cell_m) {
  require(cell_m > 0.0 && std::isfinite(cell_m), "PointIndex: cell_m must be > 0 m");
  std::vector<int> finite;
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Zero();
  for (int i = 0; i < points_.cols(); ++i) {
    if (!points_.col(i).allFinite()) continue;
    low = finite.empty() ? points_.col(i).eval() : low.cwiseMin(points_.col(i)).eval();
    high = finite.empty() ? points_.col(i).eval() : high.cwiseMax(points_.col(i)).eval();
    finite.push_back(i);
  }
  if (finite.empty()) return;
  const double limit = std::max(kMinCells, kCellsPerPoint * static_cast<double>(finite.size()));
  const Eigen::Vector2d size = high - low;
  while ((size.x() / cell_m_ + 1.0) * (size.y() / cell_m_ + 1.0) > limit) cell_m_ *= 2.0;
  origin_ = low;
  width_ = static_cast<int>(size.x() / cell_m_) + 1;
  height_ = static_cast<int>(size.y() / cell_m_) + 1;

  const auto cell_of = [this](int i) {
    const Eigen::Vector2d at = (points_.col(i) - origin_) / cell_m_;
    return std::min(static_cast<int>(at.y()), height_ - 1) * width_ +
           std::min(static_cast<int>(at.x()), width_ - 1);
  };
  cell_begin_.assign(static_cast<std::size_t>(width_) * height_ + 1, 0);
  for (const int i : finite) ++cell_begin_[cell_of(i) + 1];
  for (std::size_t c = 1; c < cell_begin_.size(); ++c) cell_begin_[c] += cell_begin_[c - 1];
  order_.resize(finite.size());
  std::vector<int> next(cell_begin_.begin(), cell_begin_.end() - 1);
  for (const int i : finite) order_[next[cell_of(i)]++] = i;
}

void PointIndex::search_cell(int x, int y, const Eigen::Vector2d& query, Neighbour& best) const {
  const int cell = y * width_ + x;
  for (int k = cell_begin_[cell]; k < cell_begin_[cell + 1]; ++k) {
    const int i = order_[k];
    const double squared = (points_.col(i) - query).squaredNorm();
    const bool nearer = squared < best.squared_m2;
    const bool tie = squared == best.squared_m2 && (best.index < 0 || i < best.index);
    if (nearer || tie) best = {i, squared};
  }
}

void PointIndex::search_ring(const Box& ring, const Eigen::Vector2d& query, Neighbour& best) const {
  for (int y = std::max(ring.y0, 0); y <= std::min(ring.y1, height_ - 1); ++y) {
    const bool whole_row = y == ring.y0 || y == ring.y1;
    if (whole_row) {
      for (int x = std::max(ring.x0, 0); x <= std::min(ring.x1, width_ - 1); ++x) {
        search_cell(x, y, query, best);
      }
      continue;
    }
    if (ring.x0 >= 0 && ring.x0 < width_) search_cell(ring.x0, y, query, best);
    if (ring.x1 >= 0 && ring.x1 < width_) search_cell(ring.x1, y, query, best);
  }
}

PointIndex::Neighbour PointIndex::nearest(const Eigen::Vector2d& query, double radius_m) const {
  Neighbour best{-1, radius_m * radius_m};
  if (order_.empty() || !query.allFinite()) return {};
  const Eigen::Vector2d at = (query - origin_) / cell_m_;
  const double reach = radius_m / cell_m_ + 1.0;
  const Eigen::Vector2d size(width_, height_);
  if ((at.array() < -reach).any() || (at.array() > size.array() + reach).any()) return {};
  const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
  // Rings wholly outside the grid hold nothing: begin at the first that touches it, end with the
  // last.
  const int first = std::max({0, -x, -y, x - width_ + 1, y - height_ + 1});
  const int last = std::max({x, y, width_ - 1 - x, height_ - 1 - y});
  for (int ring = first; ring <= last; ++ring) {
    const double untouched_m = (ring - 1) * cell_m_;  // nothing in this ring is nearer
    if (ring > 0 && untouched_m * untouched_m > best.squared_m2) break;
    search_ring({x - ring, y - ring, x + ring, y + ring}, query, best);
  }
  return best.index < 0 ? Neighbour{} : best;
}

}  // namespace marco::slam
