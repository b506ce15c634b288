#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace marco::mapping3d {

/// Squared distances to a set of planes, weighted and summed (Garland and Heckbert, SIGGRAPH 1997,
/// section 5), as a mean.
class Quadric {
 public:
  /// @param normal  unit length. @param offset_m  of the plane: normal . x = offset
  void add(const Eigen::Vector3d& normal, double offset_m, double weight) {
    matrix_.noalias() += weight * normal * normal.transpose();
    vector_ -= weight * offset_m * normal;
    constant_ += weight * offset_m * offset_m;
    weight_ += weight;
  }
  void add(const Quadric& other) {
    matrix_ += other.matrix_;
    vector_ += other.vector_;
    constant_ += other.constant_;
    weight_ += other.weight_;
  }
  /// Mean of this quadric's and another's planes [m2].
  double mean_with(const Quadric& other, const Eigen::Vector3d& at_m) const {
    const double weight = weight_ + other.weight_;
    return weight > 0.0 ? std::max(0.0, sum(at_m) + other.sum(at_m)) / weight : 0.0;
  }

  double weight() const { return weight_; }

 private:
  double sum(const Eigen::Vector3d& at_m) const {
    return at_m.dot(matrix_ * at_m) + 2.0 * vector_.dot(at_m) + constant_;
  }

  Eigen::Matrix3d matrix_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d vector_ = Eigen::Vector3d::Zero();
  double constant_ = 0.0;
  double weight_ = 0.0;
};

}  // namespace marco::mapping3d
