#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "slam/matching/correspondences.hpp"
#include "slam/matching/surfel_map.hpp"

namespace marco::slam {

struct SurfelMatcherOptions {
  /// Cell sizes of the pyramid of local maps, coarse first: the search radius of a correspondence.
  std::vector<double> cells_m = {0.6, 0.2, 0.1};
  /// Sigma of the robust kernel (Lorentzian) at each level: the thesis' schedule. From about 2 cm
  /// of range noise on the finer levels' grow with it.
  std::vector<double> sigmas_m = {0.20, 0.06, 0.02};
  /// Every nth point is used at each level.
  std::vector<double> every_nth_point = {4, 2, 1};
  int max_iterations = 12;     ///< per level
  double stop_below_m = 2e-4;  ///< the finest level has converged when a step is shorter
  double stop_below_deg = 0.005;
  /// Below this step the finest level keeps its correspondences: alternating ones would keep the
  /// pose from settling.
  double keep_walls_below_m = 2e-3;
  double keep_walls_below_deg = 0.1;
  /// A coarser level ends when a step is shorter than this part of its sigma (and as many radians).
  double coarse_stop_sigmas = 0.05;
  double half_width_m = 40.0;      ///< of the local map about its centre
  double noise_floor_m = 0.01;     ///< least standard deviation of a residual, for the covariance
  double correlated_points = 4.0;  ///< neighbouring points with correlated errors count as one

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("cells_m", cells_m, Limits{0.02, 5.0},
               "Cell size of the local map on each level, coarse first. It limits how far a point "
               "may lie from its wall.");
    v.advanced("sigmas_m", sigmas_m, Limits{0.001, 5.0},
               "Width of the Lorentzian kernel on each level. It grows by itself for range noise "
               "above 2 cm.");
    v.advanced("every_nth_point", every_nth_point, Limits{1, 1000},
               "Each level uses every Nth point. More to save time.");
    v.advanced("half_width_m", half_width_m, Limits{1.0, 200.0},
               "Half-width of the local map. More for lasers that see farther.");
    v.advanced("noise_floor_m", noise_floor_m, kPositive,
               "Lower bound of the standard deviation of a point in the covariance of a match. "
               "More for rough walls.");
    v.advanced("correlated_points", correlated_points, Limits{1.0, 100.0},
               "Number of neighbouring points that count as one in the covariance, because their "
               "errors are correlated.");
  }
};

/// The pose predicted without the scan.
struct PosePrior {
  Pose2 map_from_robot;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), map frame
  /// Degrees of freedom of Student's t distribution, whose tails release a prediction that the
  /// scan contradicts (as IRLS: Lange, Little & Taylor 1989); 0 = the normal distribution.
  double freedom = 0.0;

  /// Factor of the information at a pose that is off by (x, y, theta): the farther, the less.
  double weight(const Eigen::Vector3d& off) const;
  /// The negative logarithm of the likelihood there, but for a constant.
  double cost(const Eigen::Vector3d& off) const;
};

struct SurfelMatch {
  enum class Status {
    converged,
    iteration_limit,  ///< the pose is usable, but had not converged
    no_overlap        ///< too few correspondences; the pose is the guess
  };

  Status status = Status::no_overlap;
  Pose2 map_from_robot;
  /// Information matrix of (x, y, theta) without the prior, map frame.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double overlap = 0.0;  ///< part of the points that are inliers: within 3 sigma of a surfel's line
  double rms_m = 0.0;    ///< of the inliers' residuals
  double misfit_m2 = 0.0;  ///< mean squared residual; an outlier's counts as 3 sigma
  int iterations = 0;      ///< of all levels
};

/// A local map at several resolutions.
class SurfelPyramid {
 public:
  SurfelPyramid(const SurfelMatcherOptions& options, const Eigen::Vector2d& centre_m);
  /// Clears the map and moves its centre; memory is kept.
  void restart(const Eigen::Vector2d& centre_m);
  /// @returns see SurfelMap::add(), of the finest level
  double add(const OrientedPoints& points, const Pose2& map_from_points);
  const std::vector<SurfelMap>& levels() const { return levels_; }

 private:
  std::vector<SurfelMap> levels_;
};

/// Classification of a point by a match.
enum class PointFate : uint8_t {
  on_wall,   ///< inlier: within 3 sigma of a surfel's line
  off_wall,  ///< outlier: farther from its surfel's line
  no_wall    ///< no surfel near: new ground, or an outlier
};

/// Scan matching against a local map of surfels: point-to-line ICP with a robust kernel, coarse to
/// fine. A fast version of thesis B's match with calculated points (ch. 3.4), which minimizes the
/// Lorentzian of each point's distance from its line. What differs: the lines are those of a local
/// map of many scans instead of one scan's; the minimizer is Gauss-Newton on iteratively reweighted
/// least squares (weight 1/(1 + e^2/2 sigma^2); Holland and Welsch) instead of the exact Hessian,
/// which is not positive definite far from the optimum. Two steps follow each search of
/// correspondences; Levenberg's damping is used after a step that raised the cost. The prior is one
/// more term. Const: safe from several threads.
class SurfelMatcher {
 public:
  /// @throws std::invalid_argument unless the three lists by level have the same length.
  explicit SurfelMatcher(const SurfelMatcherOptions& options = {});

  /// @param prior may be null.
  /// @param fates receives one a point; may be null.
  SurfelMatch match(const SurfelPyramid& map,
                    const OrientedPoints& points_in_robot,
                    const Pose2& map_from_robot_guess,
                    const PosePrior* prior,
                    std::vector<PointFate>* fates = nullptr) const;
  /// From a pose on the walls: the finest level alone. On the coarser ones, whose
  /// kernels are wide, a prior that contradicts the scan would win.
  SurfelMatch refined(const SurfelPyramid& map,
                      const OrientedPoints& points_in_robot,
                      const Pose2& map_from_robot,
                      const PosePrior& prior) const;

  const SurfelMatcherOptions& options() const { return options_; }

 private:
  struct Level;
  SurfelMatch match_from(std::size_t first_level,
                         const SurfelPyramid& map,
                         const OrientedPoints& points_in_robot,
                         const Pose2& map_from_robot_guess,
                         const PosePrior* prior,
                         std::vector<PointFate>* fates) const;
  double kernel_sigma_m(std::size_t level, double range_sigma_m) const;
  void run_level(const Level& level, Correspondences& points, SurfelMatch& match) const;
  bool judge(const Correspondences& points,
             const Pose2& centre_from_robot,
             double sigma_m,
             SurfelMatch& match,
             std::vector<PointFate>* fates) const;

  SurfelMatcherOptions options_;
};

}  // namespace marco::slam
