#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace marco {

/// The motion in the plane that lays points on others best: least squares of the distances of
/// pairs (Umeyama 1991, equations 40 to 42 in two dimensions without scale, in closed form).
/// @param from, to  one column a point, m; pairs have the same column. One at least.
/// @returns the frame of `to` from the frame of `from`.
Pose2 rigid_fit(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to);

/// How far apart the pairs remain, m, after `from` was laid on `to`.
Eigen::VectorXd distances_after_fit(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to);

}  // namespace marco
