#include "mapping3d/surfels.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace marco::mapping3d {

namespace {

// Sums over the points of one block, about its first point.
struct BlockSums {
  Eigen::Vector3d reference = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double count = 0.0;
};

BlockSums sums_over(const ScenePoints& scene,
                    std::size_t row,
                    std::size_t column,
                    std::size_t block) {
  BlockSums sums;
  for (std::size_t r = row; r < row + block; ++r) {
    for (std::size_t c = column; c < column + block; ++c) {
      if (scene.valid[scene.index(r, c)] == 0) continue;
      const Eigen::Vector3d point = scene.points_m[scene.index(r, c)].cast<double>();
      if (sums.count == 0.0) sums.reference = point;
      const Eigen::Vector3d offset = point - sums.reference;
      sums.sum += offset;
      sums.squares.noalias() += offset * offset.transpose();
      sums.count += 1.0;
    }
  }
  return sums;
}

// The plane through a block's points; its normal may face either way.
std::optional<Surfel> fit(const BlockSums& sums, const SurfelOptions& options) {
  const double max_thickness2 = options.max_thickness_m * options.max_thickness_m;
  const double max_length2 = options.max_half_length_m * options.max_half_length_m;
  const Eigen::Vector3d mean = sums.sum / sums.count;
  const Eigen::Matrix3d covariance = sums.squares / sums.count - mean * mean.transpose();
  if (covariance.trace() > 2.0 * max_length2) return std::nullopt;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  // A line of points has no plane.
  if (solver.eigenvalues()[0] > max_thickness2 ||
      solver.eigenvalues()[1] < 4.0 * solver.eigenvalues()[0]) {
    return std::nullopt;
  }
  return Surfel{sums.reference + mean, solver.eigenvectors().col(0),
                std::sqrt(std::max(0.0, solver.eigenvalues()[0])), 0, 0};
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
  for (std::size_t row = 0; row + block <= scene.rows; row += block) {
    for (std::size_t column = 0; column + block <= scene.columns; column += block) {
      const BlockSums sums = sums_over(scene, row, column, block);
      if (sums.count < needed) continue;
      std::optional<Surfel> surfel = fit(sums, options);
      if (!surfel) continue;
      surfel->row = row;
      surfel->column = column;
      const Eigen::Vector3d origin = scene.origins_m[row].cast<double>();
      if (surfel->normal.dot(surfel->center_m - origin) > 0.0) surfel->normal = -surfel->normal;
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
