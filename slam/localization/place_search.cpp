#include "slam/localization/place_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <unordered_map>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// Candidates of one bucket are one place, the best of them.
constexpr double kBucketM = 1.0;
constexpr double kBucketRad = std::numbers::pi / 9.0;

}  // namespace

BlockTable::BlockTable(const LikelihoodPyramid& map, int max_blocks) {
  const auto blocks_at = [](int cells, int level) { return (cells + (1 << level) - 1) >> level; };
  while (level_ + 1 < map.levels() &&
         blocks_at(map.width_cells(), level_) * blocks_at(map.height_cells(), level_) >
             max_blocks) {
    ++level_;
  }
  columns_ = blocks_at(map.width_cells(), level_);
  rows_ = blocks_at(map.height_cells(), level_);
  // A block that begins before the map may still reach into it.
  first_ = 1;
  width_ = columns_ + first_;
  height_ = rows_ + first_;
  const int side = 1 << level_;
  values_.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) *
                         static_cast<std::size_t>(height_) * static_cast<std::size_t>(width_) +
                     kLanes,
                 0);
  uint8_t* value = values_.data();
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      for (int row = -first_; row < rows_; ++row) {
        for (int column = -first_; column < columns_; ++column) {
          *value++ =
              static_cast<uint8_t>(map.at(level_, (column << level_) + x, (row << level_) + y));
        }
      }
    }
  }
}

void BlockTable::add(int x_cells, int y_cells, uint16_t* sums) const {
  using Bytes = uint8_t __attribute__((vector_size(kLanes)));
  using Sums = uint16_t __attribute__((vector_size(2 * kLanes)));
  const int side = 1 << level_, mask = side - 1;
  // Shifts round down, also below zero.
  const int column = (x_cells >> level_) + first_, row = (y_cells >> level_) + first_;
  const uint8_t* layer =
      values_.data() +
      static_cast<std::ptrdiff_t>((y_cells & mask) * side + (x_cells & mask)) * height_ * width_;
  const int first_x = std::max(0, -column), last_x = std::min(columns_, width_ - column);
  const int first_y = std::max(0, -row), last_y = std::min(rows_, height_ - row);
  for (int y = first_y; y < last_y; ++y) {
    const uint8_t* from = layer + static_cast<std::ptrdiff_t>(row + y) * width_ + column;
    uint16_t* to = sums + static_cast<std::ptrdiff_t>(y) * stride();
    int x = first_x;
    for (; x + kLanes <= last_x; x += kLanes) {
      Bytes bytes;
      Sums sum;
      std::memcpy(&bytes, from + x, sizeof(bytes));
      std::memcpy(&sum, to + x, sizeof(sum));
      sum += __builtin_convertvector(bytes, Sums);
      std::memcpy(to + x, &sum, sizeof(sum));
    }
    for (; x < last_x; ++x) to[x] = static_cast<uint16_t>(to[x] + from[x]);
  }
}

PlaceSearch::PlaceSearch(const LikelihoodPyramid& map,
                         const BlockTable& blocks,
                         const Points2& points,
                         const Limits& limits)
    : map_(map), blocks_(blocks), points_(static_cast<int>(points.cols())) {
  require(points_ > 0 && points_ <= kMaxPoints, "place_search: no points, or too many to count");
  min_sum_ = static_cast<int>(limits.min_score * 255.0 * points_);
  keep_within_ = static_cast<int>(limits.keep_within * 255.0 * points_);
  const double reach_m = std::max(2.0, 0.5 * points.colwise().norm().maxCoeff());
  const int turns =
      static_cast<int>(std::ceil(2.0 * std::numbers::pi * reach_m / map.resolution_m()));
  for (int turn = 0; turn < turns; ++turn) {
    const double theta_rad = normalize_angle(2.0 * std::numbers::pi * turn / turns);
    const Points2 turned = Pose2{0, 0, theta_rad}.rotation() * points / map.resolution_m();
    Turned cells;
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      cells.push_back({static_cast<int>(std::floor(turned(0, i) + 0.5)),
                       static_cast<int>(std::floor(turned(1, i) + 0.5))});
    }
    thetas_rad_.push_back(theta_rad);
    turned_.push_back(std::move(cells));
  }
}

int PlaceSearch::threshold() const { return std::max(min_sum_, best_sum_ - keep_within_); }

PlaceSearch::Block PlaceSearch::scored(int level, Block block) const {
  const Turned& cells = turned_[static_cast<std::size_t>(block.turn)];
  const int wanted = threshold();
  block.sum = 0;
  // What cannot reach the threshold any more need not be counted to its end.
  constexpr std::size_t kAtOnce = 16;
  for (std::size_t first = 0; first < cells.size(); first += kAtOnce) {
    const std::size_t end = std::min(cells.size(), first + kAtOnce);
    for (std::size_t i = first; i < end; ++i) {
      block.sum += map_.at(level, cells[i].x + block.x, cells[i].y + block.y);
    }
    if (block.sum + 255 * static_cast<int>(cells.size() - end) < wanted) break;
  }
  return block;
}

void PlaceSearch::keep(const Block& place) {
  const double bucket_cells = kBucketM / map_.resolution_m();
  const auto x = static_cast<uint64_t>(std::floor(place.x / bucket_cells) + 1000);
  const auto y = static_cast<uint64_t>(std::floor(place.y / bucket_cells) + 1000);
  const double turn_rad = thetas_rad_[static_cast<std::size_t>(place.turn)] + std::numbers::pi;
  const auto turn = static_cast<uint64_t>(turn_rad / kBucketRad);
  const auto [bucket, is_new] = buckets_.try_emplace((turn << 48U) | (y << 24U) | x, place);
  if (!is_new && place.sum > bucket->second.sum) bucket->second = place;
  best_sum_ = std::max(best_sum_, place.sum);
}

void PlaceSearch::branch(int level, std::span<Block> blocks) {
  // Best bound first; ties by place, so that the result does not depend on the sort.
  std::sort(blocks.begin(), blocks.end(), [](const Block& a, const Block& b) {
    if (a.sum != b.sum) return a.sum > b.sum;
    if (a.turn != b.turn) return a.turn < b.turn;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  for (const Block& block : blocks) {
    if (block.sum < threshold()) return;
    if (level == 0) {
      keep(block);
      continue;
    }
    const int half = 1 << (level - 1);
    std::array<Block, 4> parts;
    for (int part = 0; part < 4; ++part) {
      const Block quarter{block.turn, block.x + (part & 1) * half, block.y + (part >> 1) * half, 0};
      parts[static_cast<std::size_t>(part)] = scored(level - 1, quarter);
    }
    branch(level - 1, parts);
  }
}

std::vector<PlaceSearch::Block> PlaceSearch::bounded_blocks() const {
  const int side = 1 << blocks_.level();
  const auto stride = static_cast<std::size_t>(blocks_.stride());
  std::vector<uint16_t> sums(stride * static_cast<std::size_t>(blocks_.rows()));
  std::vector<Block> blocks;
  for (int turn = 0; turn < static_cast<int>(turned_.size()); ++turn) {
    std::fill(sums.begin(), sums.end(), uint16_t{0});
    for (const Offset& cell : turned_[static_cast<std::size_t>(turn)]) {
      blocks_.add(cell.x, cell.y, sums.data());
    }
    for (int y = 0; y < blocks_.rows(); ++y) {
      const uint16_t* row = &sums[static_cast<std::size_t>(y) * stride];
      for (int x = 0; x < blocks_.columns(); ++x) {
        if (row[x] >= min_sum_) blocks.push_back({turn, x * side, y * side, row[x]});
      }
    }
  }
  return blocks;
}

std::vector<Pose2> PlaceSearch::run(std::size_t max_count) {
  std::vector<Block> blocks = bounded_blocks();
  branch(blocks_.level(), blocks);
  std::vector<Block> kept;
  for (const auto& [key, place] : buckets_) {
    if (place.sum >= threshold()) kept.push_back(place);
  }
  std::sort(kept.begin(), kept.end(), [](const Block& a, const Block& b) {
    if (a.sum != b.sum) return a.sum > b.sum;
    if (a.turn != b.turn) return a.turn < b.turn;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  if (kept.size() > max_count) kept.resize(max_count);
  std::vector<Pose2> places;
  for (const Block& place : kept) {
    // Points were rounded to the nearest cell: a pose lies in its cell's middle.
    const Eigen::Vector2d at =
        map_.origin_m() + map_.resolution_m() * Eigen::Vector2d(place.x + 0.5, place.y + 0.5);
    places.push_back({at.x(), at.y(), thetas_rad_[static_cast<std::size_t>(place.turn)]});
  }
  return places;
}

}  // namespace marco::slam
