#include "slam/matching/correlative_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

// Farther points would only add empty cells to the table.
constexpr double kMaxTableCells = 16e6;

// Ranges that are noisier show no walls: a search among them finds nothing, and takes longest.
constexpr double kMostBlurM = 1.0;

// The running maximum of `below` over `reach` cells to the right and above. The row that is `reach`
// behind is still in the processor's cache when it is joined with the one at hand.
std::vector<uint8_t> widened(const std::vector<uint8_t>& below, unsigned width, unsigned reach) {
  const auto larger = [](uint8_t a, uint8_t b) { return std::max(a, b); };
  const unsigned inner = width > reach ? width - reach : 0;
  const std::size_t back = static_cast<std::size_t>(reach) * width;
  std::vector<uint8_t> cells(below.size());
  for (std::size_t at = 0; at < below.size(); at += width) {
    const uint8_t* from = &below[at];
    uint8_t* row = &cells[at];
    std::transform(from, from + inner, from + reach, row, larger);
    std::copy(from + inner, from + width, row + inner);
    if (at >= back) std::transform(row - back, row - back + width, row, row - back, larger);
  }
  return cells;
}

struct Cell {
  int x;
  int y;
};

// The scan's points, turned by one angle, as fine cells at the window's centre.
struct Turned {
  double theta_rad;
  std::vector<Cell> cells;
};

struct Candidate {
  int turn;
  int x;  // offset of the block's first pose, fine cells
  int y;
  int sum;  // upper bound of the points' likelihoods, less the penalty
};

// Grows as the square of the distance from the centre.
struct Penalty {
  double per_cell2 = 0.0;
  double per_turn2 = 0.0;

  // The least of a block.
  int of(const Candidate& block, int step, int middle_turn) const {
    const auto off = [step](int first) {
      return static_cast<double>(first > 0 ? first : std::min(0, first + step - 1));
    };
    const double x = off(block.x), y = off(block.y);
    const auto turn = static_cast<double>(block.turn - middle_turn);
    return static_cast<int>(per_cell2 * (x * x + y * y) + per_turn2 * turn * turn);
  }
};

// A box of poses: its middle, and how far it reaches from there. Empty by default.
struct Box {
  int x = 0, y = 0, turn = 0;
  int reach = -1, turn_reach = -1;

  // Whether it holds the whole block.
  bool holds(const Candidate& block, int step) const {
    const auto within = [this, step](int first, int middle) {
      return first >= middle - reach && first + step - 1 <= middle + reach;
    };
    return within(block.x, x) && within(block.y, y) && std::abs(block.turn - turn) <= turn_reach;
  }
};

class Search {
 public:
  Search(const LikelihoodPyramid& map,
         std::vector<Turned> turned,
         int half_width_cells,
         const Penalty& penalty,
         const Box& excluded)
      : map_(map),
        turned_(std::move(turned)),
        half_width_(half_width_cells),
        penalty_(penalty),
        excluded_(excluded) {}

  void run(int min_sum) {
    best_.sum = min_sum;
    const int top = map_.levels() - 1, step = 1 << top;
    std::vector<Candidate> candidates;
    for (int turn = 0; turn < static_cast<int>(turned_.size()); ++turn) {
      for (int y = -half_width_; y <= half_width_; y += step) {
        for (int x = -half_width_; x <= half_width_; x += step) {
          candidates.push_back(scored(top, {turn, x, y, 0}));
        }
      }
    }
    branch(top, candidates);
  }
  bool found() const { return best_.turn >= 0; }
  const Candidate& best() const { return best_; }
  int best_penalty() const { return penalty_.of(best_, 1, middle_turn()); }

 private:
  Candidate scored(int level, Candidate candidate) const {
    for (const Cell& cell : turned_[static_cast<std::size_t>(candidate.turn)].cells) {
      candidate.sum += map_.at(level, cell.x + candidate.x, cell.y + candidate.y);
    }
    candidate.sum -= penalty_.of(candidate, 1 << level, middle_turn());
    return candidate;
  }
  int middle_turn() const { return static_cast<int>(turned_.size()) / 2; }
  void branch(int level, std::vector<Candidate>& candidates) {
    // Best bound first; ties by place, so that the result does not depend on the sort.
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      if (a.sum != b.sum) return a.sum > b.sum;
      if (a.turn != b.turn) return a.turn < b.turn;
      return a.y != b.y ? a.y < b.y : a.x < b.x;
    });
    for (const Candidate& candidate : candidates) {
      if (candidate.sum <= best_.sum) return;
      if (excluded_.holds(candidate, 1 << level)) continue;
      if (level == 0) {
        best_ = candidate;
        return;
      }
      const int half = 1 << (level - 1);
      std::vector<Candidate> parts;
      for (const int dy : {0, half}) {
        for (const int dx : {0, half}) {
          const int x = candidate.x + dx, y = candidate.y + dy;
          if (x > half_width_ || y > half_width_) continue;
          parts.push_back(scored(level - 1, {candidate.turn, x, y, 0}));
        }
      }
      branch(level - 1, parts);
    }
  }

  const LikelihoodPyramid& map_;
  std::vector<Turned> turned_;
  int half_width_;
  Penalty penalty_;
  Box excluded_;
  Candidate best_{-1, 0, 0, 0};
};

}  // namespace

CorrelativeMatcherOptions adapted(CorrelativeMatcherOptions options, double range_sigma_m) {
  constexpr double kBlurSigmas = 1.6;  // of a range against a wall of the same noise
  options.blur_m = std::max(options.blur_m, kBlurSigmas * range_sigma_m);
  return options;
}

Points2 points_within(double reach_m, const Eigen::Vector2d& centre_m, const Points2& points) {
  Points2 near(2, points.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if ((points.col(i) - centre_m).cwiseAbs().maxCoeff() <= reach_m) {
      near.col(count++) = points.col(i);
    }
  }
  near.conservativeResize(2, count);
  return near;
}

LikelihoodPyramid::LikelihoodPyramid(const Points2& points_in_map,
                                     const CorrelativeMatcherOptions& options)
    : resolution_m_(options.resolution_m), pad_(1 << options.levels) {
  levels_.resize(static_cast<std::size_t>(options.levels));
  if (points_in_map.cols() == 0 || options.blur_m > kMostBlurM) return;
  const int blur = static_cast<int>(std::ceil(2.5 * options.blur_m / resolution_m_));
  origin_m_ = points_in_map.rowwise().minCoeff().array() - blur * resolution_m_;
  const Eigen::Vector2d size_cells =
      (points_in_map.rowwise().maxCoeff() - origin_m_) / resolution_m_;
  const double width = size_cells.x() + blur + pad_ + 2, height = size_cells.y() + blur + pad_ + 2;
  if (!(width * height < kMaxTableCells)) return;
  width_ = static_cast<unsigned>(width);
  height_ = static_cast<unsigned>(height);
  std::vector<uint8_t>& fine = levels_.front();
  fine.assign(static_cast<std::size_t>(width_) * height_, 0);
  std::vector<uint8_t> kernel;
  for (int y = -blur; y <= blur; ++y) {
    for (int x = -blur; x <= blur; ++x) {
      const double d2 = (x * x + y * y) * resolution_m_ * resolution_m_;
      kernel.push_back(static_cast<uint8_t>(
          std::lround(255.0 * std::exp(-0.5 * d2 / (options.blur_m * options.blur_m)))));
    }
  }
  for (Eigen::Index i = 0; i < points_in_map.cols(); ++i) {
    const Eigen::Vector2d at = (points_in_map.col(i) - origin_m_) / resolution_m_;
    const int cx = static_cast<int>(at.x()) + pad_, cy = static_cast<int>(at.y()) + pad_;
    const uint8_t* value = kernel.data();
    for (int y = cy - blur; y <= cy + blur; ++y) {
      uint8_t* row =
          &fine[static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(cx - blur)];
      for (int x = 0; x <= 2 * blur; ++x, ++row, ++value) *row = std::max(*row, *value);
    }
  }
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    levels_[level] = widened(levels_[level - 1], width_, 1U << (level - 1));
  }
}

CorrelativeMatcher::CorrelativeMatcher(const CorrelativeMatcherOptions& options)
    : options_(options) {
  validate(options, "correlative_matcher");
}

CorrelativeMatch CorrelativeMatcher::search(const LikelihoodPyramid& map,
                                            const Points2& points_in_robot,
                                            const SearchWindow& window,
                                            double min_score) const {
  CorrelativeMatch match{window.map_from_robot_centre, 0.0};
  const Eigen::Index count = points_in_robot.cols();
  if (count == 0 || map.width_cells() == 0) return match;
  const Eigen::Index stride =
      std::max<Eigen::Index>(1, (count + options_.max_points - 1) / options_.max_points);
  const double reach_m = std::max(1.0, std::min(10.0, points_in_robot.colwise().norm().maxCoeff()));
  const double step_rad = options_.resolution_m / reach_m;
  const int half_turns = static_cast<int>(std::ceil(window.half_turn_rad / step_rad));
  std::vector<Turned> turned;
  for (int turn = -half_turns; turn <= half_turns; ++turn) {
    Turned one{normalize_angle(window.map_from_robot_centre.theta_rad + turn * step_rad), {}};
    const Pose2 pose{window.map_from_robot_centre.x_m, window.map_from_robot_centre.y_m,
                     one.theta_rad};
    const Eigen::Matrix2d rotation = pose.rotation();
    for (Eigen::Index i = 0; i < count; i += stride) {
      const Eigen::Vector2d at =
          (rotation * points_in_robot.col(i) + pose.translation_m() - map.origin_m()) /
          map.resolution_m();
      one.cells.push_back(
          {static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y()))});
    }
    turned.push_back(std::move(one));
  }
  const auto points = static_cast<double>(turned.front().cells.size());
  std::vector<double> thetas;
  thetas.reserve(turned.size());
  for (const Turned& one : turned) thetas.push_back(one.theta_rad);
  const int half_width = static_cast<int>(std::ceil(window.half_width_m / options_.resolution_m));
  const double at_edge = window.penalty_at_edge * 255.0 * points;
  const Penalty penalty{at_edge / std::max(1, half_width * half_width),
                        at_edge / std::max(1, half_turns * half_turns)};
  Box excluded;
  if (window.excluded) {
    const Eigen::Vector3d off =
        difference(window.excluded->map_from_robot, window.map_from_robot_centre);
    excluded = {static_cast<int>(std::lround(off.x() / options_.resolution_m)),
                static_cast<int>(std::lround(off.y() / options_.resolution_m)),
                half_turns + static_cast<int>(std::lround(off.z() / step_rad)),
                static_cast<int>(window.excluded->half_width_m / options_.resolution_m),
                static_cast<int>(window.excluded->half_turn_rad / step_rad)};
  }
  Search search(map, std::move(turned), half_width, penalty, excluded);
  search.run(static_cast<int>(min_score * 255.0 * points));
  if (!search.found()) return match;
  const Candidate& best = search.best();
  match.map_from_robot = {window.map_from_robot_centre.x_m + best.x * options_.resolution_m,
                          window.map_from_robot_centre.y_m + best.y * options_.resolution_m,
                          thetas[static_cast<std::size_t>(best.turn)]};
  match.penalty = search.best_penalty() / (255.0 * points);
  match.score = (best.sum + search.best_penalty()) / (255.0 * points);
  return match;
}

}  // namespace marco::slam
