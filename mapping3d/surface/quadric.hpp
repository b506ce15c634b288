#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

namespace marco::mapping3d {

/// Squared distances to a set of planes, weighted and summed (Garland and Heckbert, SIGGRAPH 1997,
/// section 5), as a mean. Positions are from the quadric's own origin: near it floats are enough,
/// and a mesh has millions.
class Quadric {
 public:
  /// @param normal  unit length, of a plane through `at_m`
  void add(const Eigen::Vector3f& normal, const Eigen::Vector3f& at_m, float weight) {
    add_moment(normal, -normal.dot(at_m), weight);
  }
  /// @param origin_m  of the other quadric, from this one's
  void add(const Quadric& other, const Eigen::Vector3f& origin_m) {
    // Of (x - o)' A (x - o) + 2 b' (x - o) + c.
    const Eigen::Vector3f turned = other.times(origin_m);
    constant_ += origin_m.dot(turned) - 2.0F * other.vector_.dot(origin_m) + other.constant_;
    vector_ += other.vector_ - turned;
    for (std::size_t i = 0; i < matrix_.size(); ++i) matrix_[i] += other.matrix_[i];
    weight_ += other.weight_;
  }
  /// Mean of this quadric's and another's planes [m2].
  /// @param at_m, at_of_other_m  the same place from either origin
  double mean_with(const Quadric& other,
                   const Eigen::Vector3f& at_m,
                   const Eigen::Vector3f& at_of_other_m) const {
    const float weight = weight_ + other.weight_;
    if (!(weight > 0.0F)) return 0.0;
    return static_cast<double>(std::max(0.0F, sum(at_m) + other.sum(at_of_other_m)) / weight);
  }

  double weight() const { return static_cast<double>(weight_); }

 private:
  void add_moment(const Eigen::Vector3f& n, float offset_m, float weight) {
    const Eigen::Vector3f weighted = weight * n;
    matrix_[0] += weighted.x() * n.x();
    matrix_[1] += weighted.x() * n.y();
    matrix_[2] += weighted.x() * n.z();
    matrix_[3] += weighted.y() * n.y();
    matrix_[4] += weighted.y() * n.z();
    matrix_[5] += weighted.z() * n.z();
    vector_ += offset_m * weighted;
    constant_ += weight * offset_m * offset_m;
    weight_ += weight;
  }
  Eigen::Vector3f times(const Eigen::Vector3f& v) const {
    const auto& m = matrix_;
    return {m[0] * v.x() + m[1] * v.y() + m[2] * v.z(), m[1] * v.x() + m[3] * v.y() + m[4] * v.z(),
            m[2] * v.x() + m[4] * v.y() + m[5] * v.z()};
  }
  float sum(const Eigen::Vector3f& at_m) const {
    return at_m.dot(times(at_m)) + 2.0F * vector_.dot(at_m) + constant_;
  }

  std::array<float, 6> matrix_{};  ///< xx xy xz yy yz zz
  Eigen::Vector3f vector_ = Eigen::Vector3f::Zero();
  float constant_ = 0.0F;
  float weight_ = 0.0F;
};

}  // namespace marco::mapping3d
