#include "slam/matching/surfel_matcher.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "common/check.hpp"

namespace marco::slam {
namespace {

// Upper triangle of a symmetric 3x3 and a right-hand side, summed in double.
struct Normal3 {
  double xx = 0, xy = 0, xt = 0, yy = 0, yt = 0, tt = 0;
  double bx = 0, by = 0, bt = 0;
  double cost = 0;

  Eigen::Matrix3d matrix() const {
    return (Eigen::Matrix3d() << xx, xy, xt, xy, yy, yt, xt, yt, tt).finished();
  }
  Eigen::Vector3d right() const { return {bx, by, bt}; }
};

Eigen::Vector3d pose_difference(const Pose2& a, const Pose2& b) {
  return {a.x_m - b.x_m, a.y_m - b.y_m, normalize_angle(a.theta_rad - b.theta_rad)};
}

}  // namespace

// How well points lie on the walls: those within three sigma, and their squared distances.
struct Quality {
  double near = 0;
  double squares = 0;
};

struct SurfelMatcher::Level {
  const SurfelMap& map;
  double sigma_m;
  Eigen::Index stride;
};

// Points and normals as floats in the robot's frame.
struct SurfelMatcher::Points {
  explicit Points(const OrientedPoints& oriented)
      : points(oriented.points.cast<float>()), normals(oriented.normals.cast<float>()) {}

  // Sums the reweighted squares at `pose`; the turn is about the robot's own origin.
  Normal3 sum(const Level& level, const Pose2& pose) const {
    Normal3 total;
    const auto c = static_cast<float>(std::cos(pose.theta_rad));
    const auto s = static_cast<float>(std::sin(pose.theta_rad));
    const Eigen::Vector2f shift = (pose.translation_m() - level.map.centre_m()).cast<float>();
    const double inverse_sigma2 = 1.0 / (level.sigma_m * level.sigma_m);
    // log(a) + log(b) + ... as the log of a product, taken before it can overflow.
    double product = 1.0;
    for (Eigen::Index i = 0; i < points.cols(); i += level.stride) {
      const Eigen::Vector2f arm(c * points(0, i) - s * points(1, i),
                                s * points(0, i) + c * points(1, i));
      const Eigen::Vector2f normal(c * normals(0, i) - s * normals(1, i),
                                   s * normals(0, i) + c * normals(1, i));
      const Surfel* surfel = level.map.find(arm + shift, normal);
      if (surfel == nullptr) {
        total.cost += unmatched_cost;
        continue;
      }
      const auto nx = static_cast<double>(surfel->normal.x());
      const auto ny = static_cast<double>(surfel->normal.y());
      const auto error = static_cast<double>(surfel->normal.dot(arm + shift - surfel->mean_m));
      const double scaled = 0.5 * error * error * inverse_sigma2;
      const double weight = 1.0 / (1.0 + scaled);
      const double t = ny * static_cast<double>(arm.x()) - nx * static_cast<double>(arm.y());
      total.xx += weight * nx * nx;
      total.xy += weight * nx * ny;
      total.xt += weight * nx * t;
      total.yy += weight * ny * ny;
      total.yt += weight * ny * t;
      total.tt += weight * t * t;
      total.bx += weight * error * nx;
      total.by += weight * error * ny;
      total.bt += weight * error * t;
      product *= 1.0 + scaled;
      if (product > 1e250) {
        total.cost += std::log(product);
        product = 1.0;
      }
    }
    total.cost += std::log(product);
    return total;
  }

  Quality quality(const Level& level, const Pose2& pose) const {
    Quality quality;
    const Eigen::Matrix2f turn = pose.rotation().cast<float>();
    const Eigen::Vector2f shift = (pose.translation_m() - level.map.centre_m()).cast<float>();
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Eigen::Vector2f point = turn * points.col(i) + shift;
      const Surfel* surfel = level.map.find(point, turn * normals.col(i));
      if (surfel == nullptr) continue;
      const auto error = static_cast<double>(surfel->normal.dot(point - surfel->mean_m));
      if (std::abs(error) > 3.0 * level.sigma_m) continue;
      quality.near += 1.0;
      quality.squares += error * error;
    }
    return quality;
  }

  // log(1 + e^2/2 sigma^2) at e = 3 sigma: leaving the map must not look like an improvement.
  static constexpr double unmatched_cost = 1.7047;

  Eigen::Matrix2Xf points;
  Eigen::Matrix2Xf normals;
};

SurfelPyramid::SurfelPyramid(const SurfelMatcherOptions& options, const Eigen::Vector2d& centre_m) {
  for (const double cell_m : options.cells_m) {
    levels_.emplace_back(centre_m, options.half_width_m, cell_m);
  }
}

void SurfelPyramid::add(const OrientedPoints& points, const Pose2& map_from_points) {
  for (SurfelMap& level : levels_) level.add(points, map_from_points);
}

SurfelMatcher::SurfelMatcher(const SurfelMatcherOptions& options) : options_(options) {
  validate(options, "surfel_matcher");
  require(!options.cells_m.empty() && options.cells_m.size() == options.sigmas_m.size(),
          "surfel_matcher: cells_m and sigmas_m need one value a level each");
}

Pose2 SurfelMatcher::run_level(const Level& level,
                               const Points& points,
                               const Pose2& start,
                               SurfelMatch& match,
                               const PosePrior* prior) const {
  const double scale = level.sigma_m * level.sigma_m;
  const auto with_prior = [&](Normal3 sum, const Pose2& pose) {
    struct System {
      Eigen::Matrix3d matrix;
      Eigen::Vector3d right;
      double cost;
    } system{sum.matrix(), sum.right(), sum.cost};
    if (prior != nullptr) {
      const Eigen::Vector3d difference = pose_difference(pose, prior->map_from_robot);
      system.matrix += scale * prior->information;
      system.right += scale * prior->information * difference;
      system.cost += 0.5 * difference.dot(prior->information * difference);
    }
    return system;
  };
  Pose2 pose = start;
  auto system = with_prior(points.sum(level, pose), pose);
  double lambda = 1e-4;
  bool settled = false;
  for (int i = 0; i < options_.max_iterations && !settled; ++i) {
    ++match.iterations;
    Eigen::Matrix3d damped = system.matrix;
    damped.diagonal() += lambda * system.matrix.diagonal() + Eigen::Vector3d::Constant(1e-9);
    const Eigen::Vector3d step = damped.ldlt().solve(-system.right);
    const Pose2 next{pose.x_m + step.x(), pose.y_m + step.y(),
                     normalize_angle(pose.theta_rad + step.z())};
    settled = step.head<2>().norm() < options_.stop_below_m &&
              std::abs(step.z()) < deg_to_rad(options_.stop_below_deg);
    const auto next_system = with_prior(points.sum(level, next), next);
    if (next_system.cost <= system.cost) {
      pose = next;
      system = next_system;
      lambda = std::max(lambda * 0.1, 1e-7);
    } else {
      lambda *= 10.0;
      settled = settled || lambda > 1e3;
    }
  }
  match.status = settled ? SurfelMatch::Status::converged : SurfelMatch::Status::iteration_limit;
  return pose;
}

SurfelMatch SurfelMatcher::match(const SurfelPyramid& map,
                                 const OrientedPoints& points_in_robot,
                                 const Pose2& map_from_robot_guess,
                                 const PosePrior* prior) const {
  SurfelMatch match;
  match.map_from_robot = map_from_robot_guess;
  if (points_in_robot.points.cols() == 0) return match;
  const Points points(points_in_robot);
  Pose2 pose = map_from_robot_guess;
  for (std::size_t level = 0; level < map.levels().size(); ++level) {
    pose = run_level({map.levels()[level], options_.sigmas_m[level],
                      static_cast<Eigen::Index>(options_.every_nth_point[level])},
                     points, pose, match, prior);
  }
  const Level finest{map.levels().back(), options_.sigmas_m.back(), 1};
  judge(finest, points, pose, match);
  return match;
}

void SurfelMatcher::judge(const Level& finest,
                          const Points& points,
                          const Pose2& pose,
                          SurfelMatch& match) const {
  const Quality quality = points.quality(finest, pose);
  const auto count = static_cast<double>(points.points.cols());
  match.overlap = quality.near / count;
  if (quality.near < 3.0) {
    match.status = SurfelMatch::Status::no_overlap;
    return;
  }
  match.map_from_robot = pose;
  match.rms_m = std::sqrt(quality.squares / quality.near);
  const double noise_m = std::max(match.rms_m, options_.noise_floor_m);
  match.information =
      points.sum(finest, pose).matrix() / (noise_m * noise_m * options_.correlated_points);
}

}  // namespace marco::slam
