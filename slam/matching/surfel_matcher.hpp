#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "slam/matching/surfel_map.hpp"
#include "slam/matching/tied_points.hpp"

namespace marco::slam {

struct SurfelMatcherOptions {
  /// Cells of the pyramid of local maps, coarse first: how far a point may find its wall.
  std::vector<double> cells_m = {0.6, 0.2, 0.1};
  /// Lorentzian's sigma at each level: the thesis' schedule of runs.
  std::vector<double> sigmas_m = {0.20, 0.06, 0.02};
  /// Only every nth point is used while the match is still coarse.
  std::vector<double> every_nth_point = {4, 2, 1};
  int max_iterations = 12;     ///< a level
  double stop_below_m = 2e-4;  ///< step at which the finest level has converged
  double stop_below_deg = 0.005;
  /// Each point keeps its wall when a step of the finest level is smaller: partners that change to
  /// and fro would keep the pose from settling.
  double keep_walls_below_m = 2e-3;
  double keep_walls_below_deg = 0.1;
  /// A coarser level ends at a step of this part of its sigma, and as many radians: the next one
  /// goes on from there.
  double coarse_stop_sigmas = 0.05;
  double half_width_m = 40.0;      ///< of the local map about its centre
  double noise_floor_m = 0.01;     ///< of a point about a surfel, for the covariance
  double correlated_points = 4.0;  ///< neighbouring points err alike: so many count as one

  template <class Visitor>
  void visit(Visitor& v) {
    v("cells_m", cells_m, Limits{0.02, 5.0});
    v("sigmas_m", sigmas_m, Limits{0.001, 5.0});
    v("every_nth_point", every_nth_point, Limits{1, 1000});
    v("max_iterations", max_iterations, Limits{1, 1000});
    v("stop_below_m", stop_below_m, kPositive);
    v("stop_below_deg", stop_below_deg, kPositive);
    v("keep_walls_below_m", keep_walls_below_m, kPositive);
    v("keep_walls_below_deg", keep_walls_below_deg, kPositive);
    v("coarse_stop_sigmas", coarse_stop_sigmas, kPositive);
    v("half_width_m", half_width_m, Limits{1.0, 200.0});
    v("noise_floor_m", noise_floor_m, kPositive);
    v("correlated_points", correlated_points, Limits{1.0, 100.0});
  }
};

/// What is known of the pose without the scan.
struct PosePrior {
  Pose2 map_from_robot;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), map frame
};

struct SurfelMatch {
  enum class Status {
    converged,
    iteration_limit,  ///< the pose is usable, but had not settled
    no_overlap        ///< too few points found a wall; the pose is the guess
  };

  Status status = Status::no_overlap;
  Pose2 map_from_robot;
  Eigen::Matrix3d information =
      Eigen::Matrix3d::Zero();  ///< of the scan alone, (x, y, theta), map frame
  double overlap =
      0.0;             ///< part of the points that lie within 3 sigma of a wall at the finest level
  double rms_m = 0.0;  ///< of these across their walls
  int iterations = 0;  ///< in all
};

/// The pyramid of one local map.
class SurfelPyramid {
 public:
  SurfelPyramid(const SurfelMatcherOptions& options, const Eigen::Vector2d& centre_m);
  /// Empty again, about another centre; memory is kept.
  void restart(const Eigen::Vector2d& centre_m);
  void add(const OrientedPoints& points, const Pose2& map_from_points);
  const std::vector<SurfelMap>& levels() const { return levels_; }

 private:
  std::vector<SurfelMap> levels_;
};

/// What became of a point in a match.
enum class PointFate : uint8_t {
  on_wall,   ///< within 3 sigma of a wall of the map
  off_wall,  ///< beside a wall: an outlier
  no_wall    ///< nothing of the map is near: new ground, or an outlier
};

/// Thesis B's match with calculated points (ch. 3.4) made fast: the Lorentzian of the distance
/// across the wall a point belongs to, from coarse to fine. What differs: the walls are those of a
/// local map of many scans instead of one scan's; the sum is minimized by Gauss-Newton on the
/// reweighted squares (1/(1 + e^2/2 sigma^2) is the Lorentzian's weight, method of Holland &
/// Welsch) instead of its exact Hessian, which is not positive far from the optimum; twice for each
/// search of partners, with Levenberg's damping where that made it worse; a prior from odometry is
/// one more term. Const: safe from several threads.
class SurfelMatcher {
 public:
  /// @throws std::invalid_argument unless each level has a cell size, a sigma and an nth point.
  explicit SurfelMatcher(const SurfelMatcherOptions& options = {});

  /// @param prior may be null.
  /// @param fates if not null: one a point. Costs nothing when not asked for.
  SurfelMatch match(const SurfelPyramid& map,
                    const OrientedPoints& points_in_robot,
                    const Pose2& map_from_robot_guess,
                    const PosePrior* prior,
                    std::vector<PointFate>* fates = nullptr) const;

  const SurfelMatcherOptions& options() const { return options_; }

 private:
  struct Level;
  void run_level(const Level& level, TiedPoints& points, SurfelMatch& match) const;
  bool judge(const TiedPoints& points,
             const Pose2& centre_from_robot,
             SurfelMatch& match,
             std::vector<PointFate>* fates) const;

  SurfelMatcherOptions options_;
};

}  // namespace marco::slam
