#include "slam/graph/joint_refinement.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/check.hpp"
#include "slam/graph/sparse_normal_equations.hpp"

namespace marco::slam {
namespace {

constexpr int kMaxPartners = 32;

// Points looked at in one row of cells. Where a place was seen by more, every second, third ... of
// them: a tie costs the same however long the robot was there, and the nearest of few is a fair
// sample, where the nearest of hundreds is the one whose noise agrees: scans tied to such hold each
// other where they are.
constexpr int kMaxInRow = 48;

// The next iteration finds new partners anyway: the step need not be exact (an inexact Newton
// method; Dembo, Eisenstat & Steihaug 1982). At 1e-2 the bends of a hall 100 m long are left over.
constexpr double kSolverTolerance = 1e-3;
constexpr int kSolverIterations = 300;

// All points of all scans, in the order of the cells they lie in. Single precision, seen from node
// 0: a hundredth of a millimetre in a building, and half the memory to go through.
class PlacedPoints {
 public:
  struct Point {
    Eigen::Vector2f position_m;
    Eigen::Vector2f normal;
    int scan;
  };

  PlacedPoints(const std::vector<OrientedScan>& scans,
               const std::vector<Pose2>& poses,
               double cell_m)
      : cell_m_(static_cast<float>(cell_m)) {
    std::vector<Point> unordered;
    std::size_t count = 0;
    for (const OrientedScan& scan : scans)
      count += static_cast<std::size_t>(scan.points_in_robot.cols());
    unordered.reserve(count);
    for (std::size_t scan = 0; scan < scans.size(); ++scan) {
      const Eigen::Matrix2d turn = poses[scan].rotation();
      const Eigen::Vector2d shift = poses[scan].translation_m() - poses.front().translation_m();
      for (Eigen::Index i = 0; i < scans[scan].points_in_robot.cols(); ++i) {
        unordered.push_back({(turn * scans[scan].points_in_robot.col(i) + shift).cast<float>(),
                             (turn * scans[scan].normals_in_robot.col(i)).cast<float>(),
                             static_cast<int>(scan)});
      }
    }
    lay_out(unordered);
  }

  const std::vector<Point>& points() const { return points_; }

  /// @param turn  others are passed over at another one
  template <class Visit>
  void for_each_near(const Eigen::Vector2f& at, int turn, const Visit& visit) const {
    const int cx = cell(at.x(), 0), cy = cell(at.y(), 1);
    for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, height_ - 1); ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
      const std::size_t first = row + static_cast<std::size_t>(std::max(cx - 1, 0));
      const std::size_t last = row + static_cast<std::size_t>(std::min(cx + 1, width_ - 1));
      const int begin = starts_[first], end = starts_[last + 1];
      const int step = 1 + (end - begin) / kMaxInRow;
      for (int i = begin + turn % step; i < end; i += step) {
        visit(points_[static_cast<std::size_t>(i)]);
      }
    }
  }

 private:
  int cell(float coordinate, int axis) const {
    return static_cast<int>(std::floor((coordinate - origin_m_(axis)) / cell_m_));
  }
  std::size_t index(const Point& point) const {
    return static_cast<std::size_t>(cell(point.position_m.y(), 1)) *
               static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(cell(point.position_m.x(), 0));
  }
  void lay_out(const std::vector<Point>& unordered) {
    if (unordered.empty()) return;
    origin_m_ = unordered.front().position_m;
    Eigen::Vector2f top = origin_m_;
    for (const Point& point : unordered) {
      origin_m_ = origin_m_.cwiseMin(point.position_m);
      top = top.cwiseMax(point.position_m);
    }
    // A far outlier must not make a table of the whole world: coarser cells only cost time.
    constexpr float kMaxCells = 4e6F;
    const Eigen::Vector2f size_m = top - origin_m_;
    cell_m_ = std::max(cell_m_, std::sqrt(size_m.x() * size_m.y() / kMaxCells));
    cell_m_ = std::max(cell_m_, size_m.maxCoeff() / kMaxCells);
    width_ = cell(top.x(), 0) + 1;
    height_ = cell(top.y(), 1) + 1;
    starts_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) + 1, 0);
    for (const Point& point : unordered) ++starts_[index(point) + 1];
    for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    std::vector<int> next(starts_.begin(), starts_.end() - 1);
    points_.resize(unordered.size());
    for (const Point& point : unordered) {
      points_[static_cast<std::size_t>(next[index(point)]++)] = point;
    }
  }

  float cell_m_;
  Eigen::Vector2f origin_m_ = Eigen::Vector2f::Zero();
  int width_ = 0;
  int height_ = 0;
  std::vector<int> starts_;
  std::vector<Point> points_;
};

using Point = PlacedPoints::Point;

struct Partner {
  float distance2_m2;
  const Point* point;
};

// The nearest point of each other scan, the nearest scans first. Fixed storage: this is the hot
// loop.
class PartnerList {
 public:
  explicit PartnerList(int capacity) : capacity_(capacity) {}

  void offer(const Point& point, float distance2_m2) {
    int at = 0;
    while (at < count_ && partners_[static_cast<std::size_t>(at)].point->scan != point.scan) ++at;
    if (at < count_) {
      if (partners_[static_cast<std::size_t>(at)].distance2_m2 <= distance2_m2) return;
    } else if (count_ < capacity_) {
      ++count_;
    } else {
      at = count_ - 1;
      if (partners_[static_cast<std::size_t>(at)].distance2_m2 <= distance2_m2) return;
    }
    for (; at > 0 && partners_[static_cast<std::size_t>(at - 1)].distance2_m2 > distance2_m2;
         --at) {
      partners_[static_cast<std::size_t>(at)] = partners_[static_cast<std::size_t>(at - 1)];
    }
    partners_[static_cast<std::size_t>(at)] = {distance2_m2, &point};
  }
  const Partner* begin() const { return partners_.data(); }
  const Partner* end() const { return partners_.data() + count_; }
  int count() const { return count_; }

 private:
  std::array<Partner, kMaxPartners> partners_{};
  int capacity_;
  int count_ = 0;
};

class Iteration {
 public:
  Iteration(const JointRefinementOptions& options, const std::vector<Pose2>& poses, double reach_m)
      : options_(options),
        poses_(poses),
        reach2_m2_(static_cast<float>(reach_m * reach_m)),
        normal_limit_(static_cast<float>(std::cos(deg_to_rad(options.normal_limit_deg)))),
        equations(poses.size()) {}

  void tie(const PlacedPoints& placed, std::size_t index) {
    const Point& point = placed.points()[index];
    PartnerList partners(options_.partners);
    placed.for_each_near(point.position_m, static_cast<int>(index), [&](const Point& other) {
      if (other.scan == point.scan) return;
      const float distance2 = (other.position_m - point.position_m).squaredNorm();
      if (distance2 > reach2_m2_ || other.normal.dot(point.normal) < normal_limit_) return;
      partners.offer(other, distance2);
    });
    for (const Partner& partner : partners) {
      add(point, *partner.point, 1.0 / partners.count());
    }
  }

 private:
  void add(const Point& a, const Point& b, double share) {
    // Both ends of a tie see it once each: their mean normal makes it the same tie.
    const Eigen::Vector2d normal = (a.normal + b.normal).cast<double>().normalized();
    const double error_m = normal.dot((a.position_m - b.position_m).cast<double>());
    const double sigma2 = options_.sigma_m * options_.sigma_m;
    const double weight = share / (sigma2 * (1.0 + error_m * error_m / (2.0 * sigma2)));
    const Eigen::Vector3d j_a = jacobian(a, normal), j_b = -jacobian(b, normal);
    equations.add_block(a.scan, a.scan, weight * j_a * j_a.transpose());
    equations.add_block(b.scan, b.scan, weight * j_b * j_b.transpose());
    equations.add_block(a.scan, b.scan, weight * j_a * j_b.transpose());
    equations.add_gradient(a.scan, weight * error_m * j_a);
    equations.add_gradient(b.scan, weight * error_m * j_b);
    weight_sum += weight;
    error_sum += weight * error_m * error_m;
    ++ties;
  }
  Eigen::Vector3d jacobian(const Point& point, const Eigen::Vector2d& normal) const {
    const Eigen::Vector2d robot_m = poses_[static_cast<std::size_t>(point.scan)].translation_m() -
                                    poses_.front().translation_m();
    const Eigen::Vector2d arm = point.position_m.cast<double>() - robot_m;
    return {normal.x(), normal.y(), normal.y() * arm.x() - normal.x() * arm.y()};
  }

  const JointRefinementOptions& options_;
  const std::vector<Pose2>& poses_;
  float reach2_m2_;
  float normal_limit_;

 public:
  SparseNormalEquations equations;
  double weight_sum = 0.0;
  double error_sum = 0.0;
  std::int64_t ties = 0;
};

double largest_move_m(const std::vector<Pose2>& before, const std::vector<Pose2>& after) {
  double largest = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    largest = std::max(largest, (before[i].translation_m() - after[i].translation_m()).norm());
  }
  return largest;
}

}  // namespace

JointRefinementResult refine_jointly(const std::vector<OrientedScan>& scans,
                                     const std::vector<PoseGraphEdge>& edges,
                                     const JointRefinementOptions& options,
                                     std::vector<Pose2>& poses) {
  validate(options, "joint_refinement");
  require(scans.size() == poses.size(), "refine_jointly: one pose a scan is needed");
  for (const OrientedScan& scan : scans) {
    require(scan.points_in_robot.allFinite(), "refine_jointly: a point is not finite");
  }
  JointRefinementResult result;
  if (poses.size() < 2) {
    result.converged = true;
    return result;
  }
  while (result.iterations < options.max_iterations && !result.converged) {
    // The reach shrinks by the same factor each time and arrives half way.
    const double progress = std::min(1.0, 2.0 * result.iterations / options.max_iterations);
    const double reach_m =
        options.first_reach_m * std::pow(options.last_reach_m / options.first_reach_m, progress);
    const PlacedPoints placed(scans, poses, reach_m);
    Iteration iteration(options, poses, reach_m);
    const auto stride = static_cast<std::size_t>(options.every_nth_point);
    for (std::size_t i = static_cast<std::size_t>(result.iterations) % stride;
         i < placed.points().size(); i += stride) {
      iteration.tie(placed, i);
    }
    for (const PoseGraphEdge& edge : edges) {
      add_edge_to(iteration.equations, edge, poses[static_cast<std::size_t>(edge.from)],
                  poses[static_cast<std::size_t>(edge.to)], options.edge_weight);
    }
    ++result.iterations;
    result.ties = iteration.ties;
    result.rms_m =
        iteration.weight_sum > 0 ? std::sqrt(iteration.error_sum / iteration.weight_sum) : 0.0;
    const std::vector<Pose2> before = poses;
    move_poses(poses,
               -iteration.equations.solve_iteratively(1e-6, kSolverTolerance, kSolverIterations));
    result.converged = progress >= 1.0 && largest_move_m(before, poses) < options.stop_below_m;
  }
  return result;
}

}  // namespace marco::slam
