#include "slam/back_end/graph/joint_refinement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lcm_tools/base/check.hpp"
#include "slam/back_end/graph/sparse_normal_equations.hpp"

namespace marco::slam {
namespace {

// Keyframes that a keyframe is matched with, the nearest: bounds the time.
constexpr int kMaxPartners = 32;

// Points of a cell that can be partners, some of each visit: neither the cost of a correspondence
// nor memory grows with the time spent at a place. And the nearest of a few is a fair sample; the
// nearest of hundreds is the one whose noise agrees, which holds both scans where they are.
constexpr int kMostInCell = 16;

// The next iteration finds new partners anyway: the step need not be exact (an inexact Newton
// method; Dembo, Eisenstat & Steihaug 1982). At 1e-2 the bends of a hall 100 m long are left over.
constexpr double kSolverTolerance = 1e-3;
constexpr int kSolverIterations = 300;

// Single precision, seen from node 0: a hundredth of a millimetre in a building.
struct Point {
  Eigen::Vector2f position_m;
  Eigen::Vector2f normal;
  int scan;
};

// Where the scans' points lie.
class Placement {
 public:
  Placement(const std::vector<OrientedScan>& scans, const std::vector<Pose2>& poses)
      : scans_(scans) {
    for (const Pose2& pose : poses) {
      turns_.push_back(pose.rotation());
      shifts_m_.push_back(pose.translation_m() - poses.front().translation_m());
    }
  }
  Point operator()(std::size_t scan, Eigen::Index i) const {
    return {(turns_[scan] * scans_[scan].points_in_robot.col(i) + shifts_m_[scan]).cast<float>(),
            (turns_[scan] * scans_[scan].normals_in_robot.col(i)).cast<float>(),
            static_cast<int>(scan)};
  }
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t scan = 0; scan < scans_.size(); ++scan) {
      for (Eigen::Index i = 0; i < scans_[scan].points_in_robot.cols(); ++i) {
        visit((*this)(scan, i));
      }
    }
  }

 private:
  const std::vector<OrientedScan>& scans_;
  std::vector<Eigen::Matrix2d> turns_;
  std::vector<Eigen::Vector2d> shifts_m_;
};

// A sample of all points by the cells they lie in: whatever may be a partner.
class PartnerTable {
 public:
  /// @param turn  others are taken at another one
  PartnerTable(const Placement& placement, double cell_m, int turn)
      : cell_m_(static_cast<float>(cell_m)) {
    lay_out_cells(placement);
    const int most =
        kMostInCell * static_cast<int>(std::lround(cell_m_ / static_cast<float>(cell_m)));
    std::vector<int> counts(starts_.size(), 0);
    placement.for_each([&](const Point& point) { ++counts[index(point.position_m)]; });
    std::vector<int> steps(starts_.size());
    for (std::size_t i = 0; i + 1 < starts_.size(); ++i) {
      steps[i] = 1 + (counts[i] - 1) / most;
      starts_[i + 1] = starts_[i] + (counts[i] + steps[i] - 1) / steps[i];
    }
    points_.resize(static_cast<std::size_t>(starts_.back()));
    std::vector<int> next(starts_.begin(), starts_.end() - 1), seen(starts_.size(), 0);
    placement.for_each([&](const Point& point) {
      const std::size_t cell = index(point.position_m);
      // One of each `step` in a row; of the last few, the first.
      const int in_step = seen[cell] % steps[cell], left = counts[cell] - seen[cell];
      ++seen[cell];
      if (in_step != turn % std::min(steps[cell], in_step + left)) return;
      points_[static_cast<std::size_t>(next[cell]++)] = point;
    });
  }

  template <class Visit>
  void for_each_near(const Eigen::Vector2f& at, const Visit& visit) const {
    const int cx = cell(at.x(), 0), cy = cell(at.y(), 1);
    for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, height_ - 1); ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
      const std::size_t first = row + static_cast<std::size_t>(std::max(cx - 1, 0));
      const std::size_t last = row + static_cast<std::size_t>(std::min(cx + 1, width_ - 1));
      for (int i = starts_[first]; i < starts_[last + 1]; ++i) {
        visit(points_[static_cast<std::size_t>(i)]);
      }
    }
  }

 private:
  int cell(float coordinate, int axis) const {
    return static_cast<int>(std::floor((coordinate - origin_m_(axis)) / cell_m_));
  }
  std::size_t index(const Eigen::Vector2f& position_m) const {
    return static_cast<std::size_t>(cell(position_m.y(), 1)) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(cell(position_m.x(), 0));
  }
  void lay_out_cells(const Placement& placement) {
    constexpr float kFar = std::numeric_limits<float>::max();
    Eigen::Vector2f top(-kFar, -kFar);
    origin_m_ = {kFar, kFar};
    placement.for_each([&](const Point& point) {
      origin_m_ = origin_m_.cwiseMin(point.position_m);
      top = top.cwiseMax(point.position_m);
    });
    if (top.x() < origin_m_.x()) top = origin_m_ = Eigen::Vector2f::Zero();
    // A far outlier must not make a table of the whole world: coarser cells only cost time.
    constexpr float kMaxCells = 4e6F;
    const Eigen::Vector2f size_m = top - origin_m_;
    cell_m_ = std::max(cell_m_, std::sqrt(size_m.x() * size_m.y() / kMaxCells));
    cell_m_ = std::max(cell_m_, size_m.maxCoeff() / kMaxCells);
    width_ = cell(top.x(), 0) + 1;
    height_ = cell(top.y(), 1) + 1;
    starts_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) + 1, 0);
  }

  float cell_m_;
  Eigen::Vector2f origin_m_;
  int width_ = 0;
  int height_ = 0;
  std::vector<int> starts_;
  std::vector<Point> points_;
};

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

  void add_correspondences(const PartnerTable& table, const Point& point) {
    PartnerList partners(options_.partners);
    table.for_each_near(point.position_m, [&](const Point& other) {
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
    // Each end finds the pair once: the mean normal makes both the same constraint.
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

JointRefinementOptions adapted(JointRefinementOptions options, double range_sigma_m) {
  // Between two points, each with its noise; the Lorentzian's sigma and the reach in those.
  constexpr double kSigmas = 1.2, kReachSigmas = 3.2;
  options.sigma_m = std::max(options.sigma_m, kSigmas * range_sigma_m);
  options.last_reach_m = std::max(options.last_reach_m, kReachSigmas * range_sigma_m);
  options.first_reach_m = std::max(options.first_reach_m, options.last_reach_m);
  return options;
}

JointRefinementResult refine_jointly(const std::vector<OrientedScan>& scans,
                                     const std::vector<PoseGraphEdge>& edges,
                                     const JointRefinementOptions& options,
                                     std::vector<Pose2>& poses) {
  require(scans.size() == poses.size(), "refine_jointly: expected one pose per scan");
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
    const Placement placement(scans, poses);
    const PartnerTable table(placement, reach_m, result.iterations);
    Iteration iteration(options, poses, reach_m);
    for (std::size_t scan = 0; scan < scans.size(); ++scan) {
      const auto first =
          (static_cast<Eigen::Index>(scan) + result.iterations) % options.every_nth_point;
      for (Eigen::Index i = first; i < scans[scan].points_in_robot.cols();
           i += options.every_nth_point) {
        iteration.add_correspondences(table, placement(scan, i));
      }
    }
    for (const PoseGraphEdge& edge : edges) {
      add_edge_to(iteration.equations, edge, poses, 1.0);
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
