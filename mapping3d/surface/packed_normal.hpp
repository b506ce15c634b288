#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace marco::mapping3d {

/// A direction in two bytes, to about a degree: its place on an octahedron, unfolded into a square
/// (Meyer and others, On floating-point normal vectors, 2010).
class PackedNormal {
 public:
  PackedNormal() = default;
  /// @param direction  of any length; of none becomes the z axis
  explicit PackedNormal(const Eigen::Vector3f& direction) {
    const float length = direction.cwiseAbs().sum();
    if (!(length > 0.0F)) return;
    const Eigen::Vector3f n = direction / length;
    const float u = n.z() >= 0.0F ? n.x() : folded(n.y(), n.x());
    const float v = n.z() >= 0.0F ? n.y() : folded(n.x(), n.y());
    u_ = static_cast<int8_t>(std::lround(kSteps * u));
    v_ = static_cast<int8_t>(std::lround(kSteps * v));
  }

  /// Unit length.
  Eigen::Vector3f unpacked() const {
    const float u = static_cast<float>(u_) / kSteps, v = static_cast<float>(v_) / kSteps;
    const float z = 1.0F - std::abs(u) - std::abs(v);
    const Eigen::Vector3f n =
        z >= 0.0F ? Eigen::Vector3f(u, v, z) : Eigen::Vector3f(folded(v, u), folded(u, v), z);
    return n.normalized();
  }

 private:
  static constexpr float kSteps = 127.0F;  // of a signed byte
  static float folded(float other, float own) { return std::copysign(1.0F - std::abs(other), own); }

  int8_t u_ = 0, v_ = 0;
};

}  // namespace marco::mapping3d
