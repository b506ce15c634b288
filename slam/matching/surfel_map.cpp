#include "slam/matching/surfel_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// Least cosine between the normals of one surfel: noise of one wall stays above it, the two faces
// of a thin wall and the walls of a corner below.
constexpr float kSameFacing = 0.80F;

// Position of an empty slot: never the nearest, and its square is finite.
constexpr float kNowhereM = 1e9F;

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));

Float4 load(const std::array<float, 4>& values) {
  Float4 result;
  std::memcpy(&result, values.data(), sizeof result);
  return result;
}

}  // namespace

SurfelMap::SurfelMap(const Eigen::Vector2d& centre_m, double half_width_m, double cell_m)
    : centre_m_(centre_m),
      cell_m_(cell_m),
      half_width_m_(static_cast<float>(half_width_m)),
      inverse_cell_(static_cast<float>(1.0 / cell_m)) {
  require(cell_m > 0.0 && half_width_m > 0.0 && half_width_m / cell_m < 5000.0,
          "SurfelMap: cell and width must be above 0, with fewer than 10000 cells a side");
  const int width = static_cast<int>(std::ceil(2.0 * half_width_m / cell_m)) + 3;
  blocks_wide_ = (width >> kBlockBits) + 1;
  table_.assign(static_cast<std::size_t>(blocks_wide_) * static_cast<std::size_t>(blocks_wide_), 0);
  constexpr std::size_t kUsualBlocks = 128, kUsualCells = 1024;
  blocks_.reserve(kUsualBlocks);
  cells_.reserve(kUsualCells);
  parts_.reserve(kUsualCells);
  restart(centre_m);
}

void SurfelMap::restart(const Eigen::Vector2d& centre_m) {
  centre_m_ = centre_m;
  count_ = 0;
  std::fill(table_.begin(), table_.end(), 0);
  blocks_.clear();
  cells_.clear();
  parts_.clear();
  scans_ = 0;
  blocks_.emplace_back().fill(0);
  Cell& nowhere = cells_.emplace_back();
  nowhere.mean_x_m.fill(kNowhereM);
  nowhere.mean_y_m.fill(kNowhereM);
  nowhere.normal_x.fill(0.0F);
  nowhere.normal_y.fill(0.0F);
  parts_.emplace_back();
}

double SurfelMap::add(const OrientedPoints& points, const Pose2& map_from_points) {
  ++scans_;
  double added = 0.0, of_before = 0.0;
  const Eigen::Matrix2d turn = map_from_points.rotation();
  const Eigen::Vector2d shift = map_from_points.translation_m() - centre_m_;
  for (Eigen::Index i = 0; i < points.points.cols(); ++i) {
    if (!points.has_normal(i)) continue;
    const Eigen::Vector2f point = (turn * points.points.col(i) + shift).cast<float>();
    if (!(point.cwiseAbs().maxCoeff() < half_width_m_)) continue;
    const Parts* parts = add_point(point, (turn * points.normals.col(i)).cast<float>());
    if (parts == nullptr) continue;
    const auto before = static_cast<double>(parts->before / parts->points);
    added += 1.0;
    of_before += before * before;
  }
  return added > 0.0 ? of_before / added : 1.0;
}

SurfelMap::Block& SurfelMap::block_at(int x, int y) {
  int32_t& block = table_[static_cast<std::size_t>(y) * static_cast<std::size_t>(blocks_wide_) +
                          static_cast<std::size_t>(x)];
  if (block == 0) {
    block = static_cast<int32_t>(blocks_.size());
    blocks_.emplace_back().fill(0);
  }
  return blocks_[static_cast<std::size_t>(block)];
}

int32_t SurfelMap::cell_at(int x, int y) {
  const int block_x = x >> kBlockBits, block_y = y >> kBlockBits;
  const int in_x = x & (kBlockCells - 1), in_y = y & (kBlockCells - 1);
  const auto at = [](int column, int row) {
    return static_cast<std::size_t>(row) * kBlockStride + static_cast<std::size_t>(column);
  };
  int32_t cell = block_at(block_x, block_y)[at(in_x, in_y)];
  if (cell != 0) return cell;
  cell = static_cast<int32_t>(cells_.size());
  cells_.push_back(cells_.front());
  parts_.push_back(parts_.front());
  block_at(block_x, block_y)[at(in_x, in_y)] = cell;
  // Cells of the first column or row also belong to the blocks before; x and y are at least 1.
  if (in_x == 0) block_at(block_x - 1, block_y)[at(kBlockCells, in_y)] = cell;
  if (in_y == 0) block_at(block_x, block_y - 1)[at(in_x, kBlockCells)] = cell;
  if (in_x == 0 && in_y == 0) {
    block_at(block_x - 1, block_y - 1)[at(kBlockCells, kBlockCells)] = cell;
  }
  return cell;
}

const SurfelMap::Parts* SurfelMap::add_point(const Eigen::Vector2f& point_m,
                                             const Eigen::Vector2f& normal) {
  const int x = 1 + static_cast<int>((point_m.x() + half_width_m_) * inverse_cell_);
  const int y = 1 + static_cast<int>((point_m.y() + half_width_m_) * inverse_cell_);
  const auto index = static_cast<std::size_t>(cell_at(x, y));
  Cell& cell = cells_[index];
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    Parts& parts = parts_[index][slot];
    const float weight = parts.points;
    float &nx = cell.normal_x[slot], &ny = cell.normal_y[slot];
    if (weight > 0.0F && nx * normal.x() + ny * normal.y() <= kSameFacing) continue;
    if (parts.newest_scan != scans_) parts.before = weight;
    parts.newest_scan = scans_;
    parts.points += 1.0F;
    if (weight == 0.0F) {
      cell.mean_x_m[slot] = point_m.x();
      cell.mean_y_m[slot] = point_m.y();
      nx = normal.x();
      ny = normal.y();
      ++count_;
      return &parts;
    }
    const float part = 1.0F / (weight + 1.0F);
    cell.mean_x_m[slot] += part * (point_m.x() - cell.mean_x_m[slot]);
    cell.mean_y_m[slot] += part * (point_m.y() - cell.mean_y_m[slot]);
    const float x_sum = nx * weight + normal.x(), y_sum = ny * weight + normal.y();
    const float inverse_length = 1.0F / std::sqrt(x_sum * x_sum + y_sum * y_sum);
    nx = x_sum * inverse_length;
    ny = y_sum * inverse_length;
    return &parts;
  }
  return nullptr;
}

SurfelMap::Place SurfelMap::nearest(const Eigen::Vector2f& point_m,
                                    const Eigen::Vector2f& normal) const {
  if (!(std::abs(point_m.x()) < half_width_m_ && std::abs(point_m.y()) < half_width_m_)) {
    return {&cells_.front(), -1};
  }
  // The first of the four cells whose centres surround the point.
  const int x = static_cast<int>((point_m.x() + half_width_m_) * inverse_cell_ + 0.5F);
  const int y = static_cast<int>((point_m.y() + half_width_m_) * inverse_cell_ + 0.5F);
  const int32_t block_index =
      table_[static_cast<std::size_t>(y >> kBlockBits) * static_cast<std::size_t>(blocks_wide_) +
             static_cast<std::size_t>(x >> kBlockBits)];
  const int32_t* first = blocks_[static_cast<std::size_t>(block_index)].data() +
                         static_cast<std::ptrdiff_t>(y & (kBlockCells - 1)) * kBlockStride +
                         (x & (kBlockCells - 1));
  const std::array<const Cell*, 4> around = {
      &cells_[static_cast<std::size_t>(first[0])], &cells_[static_cast<std::size_t>(first[1])],
      &cells_[static_cast<std::size_t>(first[kBlockStride])],
      &cells_[static_cast<std::size_t>(first[kBlockStride + 1])]};
  const bool any_normal = normal.x() == 0.0F && normal.y() == 0.0F;
  const float facing = any_normal ? -2.0F : kSameFacing;
  const auto reach2 = static_cast<float>(cell_m_ * cell_m_);
  Float4 best = {reach2, reach2, reach2, reach2};
  Int4 best_cell = {-1, -1, -1, -1};
  // No branches: they could not be predicted.
  for (int32_t i = 0; i < 4; ++i) {
    const Cell& cell = *around[static_cast<std::size_t>(i)];
    const Float4 dx = load(cell.mean_x_m) - point_m.x(), dy = load(cell.mean_y_m) - point_m.y();
    const Float4 distance2 = dx * dx + dy * dy;
    const Float4 cosine = load(cell.normal_x) * normal.x() + load(cell.normal_y) * normal.y();
    const Int4 wins = (cosine >= facing) & (distance2 < best);
    best = wins ? distance2 : best;
    best_cell = wins ? Int4{i, i, i, i} : best_cell;
  }
  int slot = 0;
  for (int other = 1; other < kSlots; ++other) slot = best[other] < best[slot] ? other : slot;
  const int32_t winner = best_cell[slot];
  if (winner < 0) return {&cells_.front(), -1};
  return {around[static_cast<std::size_t>(winner)], slot};
}

WallLine SurfelMap::line_near(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal) const {
  const Place place = nearest(point_m, normal);
  if (place.slot < 0) return {};
  const auto slot = static_cast<std::size_t>(place.slot);
  const Cell& cell = *place.cell;
  return {cell.normal_x[slot], cell.normal_y[slot],
          cell.normal_x[slot] * cell.mean_x_m[slot] + cell.normal_y[slot] * cell.mean_y_m[slot]};
}

std::optional<Surfel> SurfelMap::find(const Eigen::Vector2f& point_m,
                                      const Eigen::Vector2f& normal) const {
  const Place place = nearest(point_m, normal);
  if (place.slot < 0) return std::nullopt;
  const auto slot = static_cast<std::size_t>(place.slot);
  const Cell& cell = *place.cell;
  return Surfel{{cell.mean_x_m[slot], cell.mean_y_m[slot]},
                {cell.normal_x[slot], cell.normal_y[slot]}};
}

}  // namespace marco::slam
