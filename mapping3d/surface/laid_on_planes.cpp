#include "mapping3d/surface/laid_on_planes.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace marco::mapping3d {
namespace {

// A vertex whose normal is off by 70 degrees belongs to another surface. In a room's corner it is
// off by 55 from each of three walls, with twice as much of one of them by 66 from the others.
constexpr double kMinCosine = 0.35;
// What is left after a move onto planes that contradict each other is more than rounding.
constexpr double kOnPlaneM = 1e-6;

bool is_near(const SurfacePlane& plane, const Eigen::Vector3d& at_m, double snap_m) {
  if (std::abs(plane.normal.dot(at_m) - plane.offset_m) > snap_m) return false;
  const Eigen::Vector3d d = at_m - plane.centre_m;
  const Eigen::Vector2d at(plane.along.dot(d), plane.across.dot(d));
  return (at - plane.low_m).minCoeff() >= -snap_m && (plane.high_m - at).minCoeff() >= -snap_m;
}

/// The shortest way of a point onto all of some planes.
class Way {
 public:
  explicit Way(const Eigen::Vector3d& from_m) : from_m_(from_m) {}

  /// @returns whether one more plane can be reached too, within `snap_m`.
  bool add(const SurfacePlane& plane, double snap_m) {
    Eigen::Matrix3d normals = normals_;
    Eigen::Vector3d off_m = off_m_;
    normals.row(count_) = plane.normal;
    off_m[count_] = plane.offset_m - plane.normal.dot(from_m_);
    // Rows of zeros ask for nothing.
    const Eigen::Vector3d move_m = normals.completeOrthogonalDecomposition().solve(off_m);
    const double left_m = (normals * move_m - off_m).cwiseAbs().maxCoeff();
    if (move_m.norm() > snap_m || left_m > kOnPlaneM) return false;
    normals_ = normals;
    off_m_ = off_m;
    move_m_ = move_m;
    ++count_;
    return true;
  }
  Eigen::Vector3d to_m() const { return from_m_ + move_m_; }

 private:
  Eigen::Vector3d from_m_, move_m_ = Eigen::Vector3d::Zero(), off_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d normals_ = Eigen::Matrix3d::Zero();
  Eigen::Index count_ = 0;
};

}  // namespace

std::size_t VertexPlanes::count() const {
  return static_cast<std::size_t>(std::find(numbers.begin(), numbers.end(), kNone) -
                                  numbers.begin());
}

bool VertexPlanes::are_all_of(const VertexPlanes& other) const {
  return std::all_of(numbers.begin(), numbers.end(), [&](uint32_t number) {
    return number == kNone ||
           std::find(other.numbers.begin(), other.numbers.end(), number) != other.numbers.end();
  });
}

void VertexPlanes::keep(const VertexPlanes& other) {
  const auto kept = std::remove_if(numbers.begin(), numbers.end(), [&](uint32_t number) {
    return std::find(other.numbers.begin(), other.numbers.end(), number) == other.numbers.end();
  });
  std::fill(kept, numbers.end(), kNone);
}

LaidOnPlanes laid_on_planes(const TriangleMesh& mesh,
                            const std::vector<SurfacePlane>& planes,
                            double snap_m) {
  LaidOnPlanes laid{mesh.vertices_m, std::vector<VertexPlanes>(mesh.vertices_m.size())};
  if (mesh.normals.empty()) return laid;
  for (std::size_t i = 0; i < laid.vertices_m.size(); ++i) {
    const Eigen::Vector3d from_m = mesh.vertices_m[i].cast<double>();
    const Eigen::Vector3d normal = mesh.normals[i].cast<double>();
    VertexPlanes& own = laid.planes[i];
    Way way(from_m);
    for (std::size_t k = 0; k < planes.size() && own.count() < own.numbers.size(); ++k) {
      if (!is_near(planes[k], from_m, snap_m)) continue;
      if (planes[k].normal.dot(normal) < kMinCosine || !way.add(planes[k], snap_m)) continue;
      own.numbers[own.count()] = static_cast<uint32_t>(k);
    }
    if (own.count() > 0) laid.vertices_m[i] = way.to_m().cast<float>();
  }
  return laid;
}

}  // namespace marco::mapping3d
