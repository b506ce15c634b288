#include "viewer/cell_outlines.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "common/simplify_polyline.hpp"

namespace marco::viewer {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr int kSmoothedEdges = 4;  // on each side
constexpr double kToleranceCells = 0.3;

// Directions, counter-clockwise; of each, the cells at the left and right of an edge from (0, 0).
constexpr int kDirections = 4;
const std::array<Vector2i, kDirections> kAlong{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
const std::array<Vector2i, kDirections> kLeft{{{0, 0}, {-1, 0}, {-1, -1}, {0, -1}}};
const std::array<Vector2i, kDirections> kRight{{{0, -1}, {0, 0}, {-1, 0}, {-1, -1}}};

class OutlineTracer {
 public:
  explicit OutlineTracer(const CellMask& mask)
      : mask_(mask), seen_(kDirections, CellMask(mask.width() + 1, mask.height() + 1)) {}

  std::vector<Outline> trace() {
    std::vector<Outline> outlines;
    for (int y = 0; y <= mask_.height(); ++y)
      for (int x = 0; x <= mask_.width(); ++x)
        for (int direction = 0; direction < kDirections; ++direction)
          if (is_untaken_edge({x, y}, direction)) outlines.push_back(follow({x, y}, direction));
    return outlines;
  }

 private:
  bool is_untaken_edge(const Vector2i& corner, int direction) const {
    const Vector2i left = corner + kLeft[direction], right = corner + kRight[direction];
    return mask_.at(left.x(), left.y()) && !mask_.at(right.x(), right.y()) &&
           !seen_[direction].at(corner.x(), corner.y());
  }

  Outline follow(Vector2i corner, int direction) {
    Outline outline;
    while (direction >= 0) {
      outline.push_back(corner.cast<double>());
      seen_[direction].set(corner.x(), corner.y(), true);
      corner += kAlong[direction];
      direction = next_direction(corner, direction);
    }
    return outline;
  }

  // Right first: cells that touch by a corner stay one area. -1 where the way is closed.
  int next_direction(const Vector2i& corner, int direction) const {
    for (const int turn : {3, 0, 1}) {
      const int next = (direction + turn) % kDirections;
      if (is_untaken_edge(corner, next)) return next;
    }
    return -1;
  }

  const CellMask& mask_;
  std::vector<CellMask> seen_;  // edges, a mask of their first corners for each direction
};

// Of a closed line of unit edges; any index.
const Vector2d& point_at(const Outline& outline, int index) {
  const int count = static_cast<int>(outline.size());
  return outline[static_cast<std::size_t>((index % count + count) % count)];
}

// Between two straight stretches that are no steps.
bool is_corner(const Outline& outline, int index) {
  const Vector2d before = point_at(outline, index) - point_at(outline, index - kSmoothedEdges);
  const Vector2d after = point_at(outline, index + kSmoothedEdges) - point_at(outline, index);
  return std::abs(before.norm() - kSmoothedEdges) < 1e-9 &&
         std::abs(after.norm() - kSmoothedEdges) < 1e-9 && std::abs(before.dot(after)) < 1e-9;
}

// Corners stay where they are: no average reaches beyond one.
Outline smoothed(const Outline& outline) {
  const int count = static_cast<int>(outline.size());
  const int most = std::min(kSmoothedEdges, count / 8);
  std::vector<bool> corners;
  corners.reserve(outline.size());
  for (int i = 0; i < count; ++i) corners.push_back(is_corner(outline, i));
  Outline smooth;
  for (int i = 0; i < count; ++i) {
    int reach = 0;
    const auto corner = [&](int index) {
      return corners[static_cast<std::size_t>((index % count + count) % count)];
    };
    while (reach < most && !corner(i - reach) && !corner(i + reach)) ++reach;
    Vector2d sum = Vector2d::Zero();
    double weights = 0.0;
    for (int offset = -reach; offset <= reach; ++offset) {
      const double weight = reach + 1 - std::abs(offset);
      sum += weight * point_at(outline, i + offset);
      weights += weight;
    }
    smooth.push_back(sum / weights);
  }
  return smooth;
}

Outline simplified(Outline points) {
  const Vector2d first = points.front();
  const auto opposite = std::max_element(points.begin(), points.end(), [&](auto& a, auto& b) {
    return (a - first).norm() < (b - first).norm();
  });
  const auto middle = static_cast<std::size_t>(opposite - points.begin());
  points.push_back(first);
  const std::span<const Vector2d> all(points);
  Outline kept = simplify_polyline(all.first(middle + 1), kToleranceCells);
  const Outline back = simplify_polyline(all.subspan(middle), kToleranceCells);
  kept.insert(kept.end(), back.begin() + 1, back.end() - 1);
  return kept;
}

}  // namespace

std::vector<Outline> smooth_outlines(const CellMask& mask) {
  std::vector<Outline> outlines = OutlineTracer(mask).trace();
  for (Outline& outline : outlines) outline = simplified(smoothed(outline));
  return outlines;
}

}  // namespace marco::viewer
