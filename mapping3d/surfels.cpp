#include "mapping3d/surfels.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace marco::mapping3d {

namespace {

// Beams closer together go to one place. Assumed: no pan-tilt knows its angle better.
constexpr double kLeastApartRad = 2e-4;

// Lowest noise of a range that is believed; assumed, for recordings without noise.
constexpr double kMinRangeSigmaM = 0.002;

// The largest standard error of the slope, relative to sqrt(1 + slope^2). The model of a panned
// laser: 4.5 mm rms at 0.5 and at 1, 17 mm at 0.26. More lets more noise pass.
constexpr double kMaxSlopeError = 0.5;

/// Whether the beams are far enough apart to tell how the surface faces. Where they are not, as
/// along the axis of a tilt, what spreads is the noise of the ranges, and the principal axes would
/// take it for a surface seen edge on.
/// @param covariance  of the points
/// @param beam  from the sensor to their mean
bool tells_slope(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& beam, double count) {
  const Eigen::Vector3d ray = beam.normalized(), across = ray.unitOrthogonal();
  Eigen::Matrix<double, 3, 2> plane;
  plane << across, ray.cross(across);
  const Eigen::Matrix2d spread = plane.transpose() * covariance * plane;
  const double half = 0.5 * spread.trace();
  const double narrow = half - std::sqrt(std::max(0.0, half * half - spread.determinant()));
  if (!(narrow > std::pow(kLeastApartRad, 2) * beam.squaredNorm())) return false;
  // Depth along the ray over the place across it, whose error is that of the bearings.
  const Eigen::Vector2d with_depth = plane.transpose() * covariance * ray;
  const Eigen::Vector2d slope = spread.inverse() * with_depth;
  const double residual2 =
      std::max(0.0, ray.dot(covariance * ray) - slope.dot(with_depth)) * count / (count - 3.0);
  const double sigma2 = std::max(residual2, std::pow(kMinRangeSigmaM, 2)) / (count * narrow);
  return sigma2 <= std::pow(kMaxSlopeError, 2) * (1.0 + slope.squaredNorm());
}

// The plane through a block's points.
std::optional<Surfel> fit(const std::vector<Eigen::Vector3d>& points_m,
                          const Eigen::Vector3d& origin_m,
                          const SurfelOptions& options) {
  const auto count = static_cast<double>(points_m.size());
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point_m : points_m) center += point_m;
  center /= count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3d offset = point_m - center;
    covariance.noalias() += offset * offset.transpose();
  }
  covariance /= count;
  if (covariance.trace() > 2.0 * options.max_half_length_m * options.max_half_length_m) {
    return std::nullopt;
  }
  const Eigen::Vector3d beam = center - origin_m;
  if (!tells_slope(covariance, beam, count)) return std::nullopt;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const double thickness_m = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
  // A line of points has no plane.
  if (thickness_m > options.max_thickness_m ||
      solver.eigenvalues()[1] < 4.0 * solver.eigenvalues()[0]) {
    return std::nullopt;
  }
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  return Surfel{center, normal.dot(beam) > 0.0 ? Eigen::Vector3d(-normal) : normal, thickness_m, 0,
                0};
}

std::vector<Eigen::Vector3f> centers_of(const std::vector<Surfel>& surfels) {
  std::vector<Eigen::Vector3f> centers_m;
  centers_m.reserve(surfels.size());
  for (const Surfel& surfel : surfels) centers_m.push_back(surfel.center_m.cast<float>());
  return centers_m;
}

}  // namespace

std::vector<Surfel> find_surfels(const ScenePoints& scene, const SurfelOptions& options) {
  validate(options, "surfels");
  const auto block = static_cast<std::size_t>(options.block_cells);
  const double needed = std::max(4.0, options.min_filled * static_cast<double>(block * block));
  std::vector<Surfel> surfels;
  surfels.reserve(scene.points_m.size() / (block * block));
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t row = 0; row + block <= scene.rows; row += block) {
    const Eigen::Vector3d origin_m = scene.origins_m[row].cast<double>();
    for (std::size_t column = 0; column + block <= scene.columns; column += block) {
      points_m.clear();
      for (std::size_t r = row; r < row + block; ++r) {
        for (std::size_t c = column; c < column + block; ++c) {
          const std::size_t at = scene.index(r, c);
          if (scene.valid[at] != 0) points_m.push_back(scene.points_m[at].cast<double>());
        }
      }
      if (static_cast<double>(points_m.size()) < needed) continue;
      std::optional<Surfel> surfel = fit(points_m, origin_m, options);
      if (!surfel) continue;
      surfel->row = row;
      surfel->column = column;
      surfels.push_back(*surfel);
    }
  }
  return surfels;
}

SurfelIndex::SurfelIndex(std::vector<Surfel> of_scene)
    : surfels(std::move(of_scene)), centers(centers_of(surfels)) {
  for (const Surfel& surfel : surfels) box.extend(surfel.center_m);
}

std::optional<Eigen::Vector3d> block_mean(const ScenePoints& scene, const GridBlock& block) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t row = block.row; row < block.row + block.rows; ++row) {
    for (std::size_t column = block.column; column < block.column + block.columns; ++column) {
      const std::size_t at = scene.index(row, column);
      if (scene.valid[at] == 0) continue;
      sum += scene.points_m[at].cast<double>();
      count += 1.0;
    }
  }
  if (count == 0.0) return std::nullopt;
  return Eigen::Vector3d(sum / count);
}

double quantile(std::vector<double>& values, double part) {
  if (values.empty()) return 0.0;
  const auto rank = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

}  // namespace marco::mapping3d
