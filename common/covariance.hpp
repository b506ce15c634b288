#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"

/// Covariances and information matrices (their inverses) of a pose (x, y, theta).
namespace marco {

/// Quantiles of the chi-square distribution with 3 degrees of freedom, that of the squared
/// Mahalanobis distance of a pose: 1 of 1000 correct measurements lies beyond the first.
inline constexpr double kChi2Dof3Quantile999 = 16.266;
inline constexpr double kChi2Dof3Quantile99 = 11.345;
inline constexpr double kChi2Dof3Quantile75 = 4.11;

/// Standard deviations along x and y [m], and of the heading.
Eigen::Matrix3d diagonal_covariance(double sigma_m, double sigma_rad);

/// The covariance of an information matrix that may be singular, by its eigenvalues: always
/// positive definite. Eigenvalues below zero, which rounding leaves, count as zero; a direction of
/// which nothing is known gets a standard deviation of 1000 m, or radians.
Eigen::Matrix3d covariance_of(const Eigen::Matrix3d& information);

/// The information matrix of a covariance that may be singular, the same way; no direction is known
/// better than to 0.03 mm, or mrad.
Eigen::Matrix3d information_of(const Eigen::Matrix3d& covariance);

/// What is left of an information matrix when independent noise is added to the measurement:
/// (information^-1 + noise)^-1, found without inverting `information`, which may be singular or,
/// by rounding, indefinite. Positive semidefinite, and never more than noise^-1: a direction of
/// which nothing is known stays unknown. With L L^T = noise and L^T information L = V diag(m) V^T
/// it is L^-T V diag(m / (1 + m)) V^T L^-1; m below zero counts as zero.
/// @param noise  a covariance, positive definite
Eigen::Matrix3d with_noise(const Eigen::Matrix3d& information, const Eigen::Matrix3d& noise);

/// A symmetric matrix without its eigenvalues below zero; a semidefinite one as it is.
Eigen::Matrix3d semidefinite_part(const Eigen::Matrix3d& matrix);

/// Whether a matrix can be a pose's information or covariance: finite, symmetric, and no eigenvalue
/// below zero but for rounding.
bool is_semidefinite(const Eigen::Matrix3d& matrix);

/// Standard deviation of a pose's position along its least known direction.
double position_sigma_m(const Eigen::Matrix3d& covariance);

/// A covariance or information matrix given along the axes of frame b, along those of frame a.
/// @param a_from_b_rad  heading of b in a
Eigen::Matrix3d rotated(const Eigen::Matrix3d& matrix, double a_from_b_rad);

/// The covariance of world_from_b that follows from that of world_from_a, a_from_b known exactly:
/// an error of the heading at a moves b sideways.
Eigen::Matrix3d carried_along(const Eigen::Matrix3d& covariance,
                              const Pose2& world_from_a,
                              const Pose2& world_from_b);

/// The covariance in frame a of a pose error given in frame b (the adjoint of a_from_b).
Eigen::Matrix3d transformed(const Eigen::Matrix3d& covariance, const Pose2& a_from_b);

/// (x, y, theta) of a pose less another's, both in one frame.
Eigen::Vector3d difference(const Pose2& pose, const Pose2& from);

double squared_mahalanobis_distance(const Eigen::Vector3d& error,
                                    const Eigen::Matrix3d& information);

}  // namespace marco
