#include "slam/localization/place_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "common/check.hpp"

namespace marco::slam {
namespace {

constexpr double kBucketM = 1.0;
constexpr double kBucketRad = std::numbers::pi / 9.0;

}  // namespace

PlaceSearch::PlaceSearch(const LikelihoodPyramid& map, const Points2& points, const Limits& limits)
    : map_(map), points_(static_cast<int>(points.cols())) {
  require(points_ > 0, "place_search: no points");
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

std::vector<Pose2> PlaceSearch::run(std::size_t max_count) {
  const int top = map_.levels() - 1, step = 1 << top;
  std::vector<Block> blocks;
  for (int turn = 0; turn < static_cast<int>(turned_.size()); ++turn) {
    for (int y = 0; y < map_.height_cells(); y += step) {
      for (int x = 0; x < map_.width_cells(); x += step) {
        const Block block = scored(top, {turn, x, y, 0});
        if (block.sum >= min_sum_) blocks.push_back(block);
      }
    }
  }
  branch(top, blocks);
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
