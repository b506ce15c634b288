#include "slam/matching/normal_noise.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace marco::slam {

Points2 without_noise(Points2 normals) {
  const Eigen::Matrix2d sum = normals * normals.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(sum);
  const double along = solver.eigenvalues()[0], across = solver.eigenvalues()[1];
  if (!(along > 0.0)) return normals;
  const double honest = std::max(0.0, along - kNormalSigma * kNormalSigma * across);
  const double noise = 1.0 - std::sqrt(honest / along);
  const Eigen::Vector2d direction = solver.eigenvectors().col(0);
  for (Eigen::Index i = 0; i < normals.cols(); ++i) {
    const double off = direction.dot(normals.col(i));
    if (std::abs(off) > 3.0 * kNormalSigma) continue;
    normals.col(i) = (normals.col(i) - noise * off * direction).normalized();
  }
  return normals;
}

}  // namespace marco::slam
