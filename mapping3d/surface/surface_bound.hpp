#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/triangle_mesh.hpp"
#include "mapping3d/surface/mesh_distance.hpp"

namespace marco::mapping3d {

/// Keeps a mesh that changes step by step within a distance of what it was, both ways. Samples and
/// vertices of the original each know a triangle of the changing mesh that lies within the limit of
/// them (as Ciampalini and others, The Visual Computer 1997); triangles that a step makes are
/// sampled against the original.
class SurfaceBound {
 public:
  /// A triangle as a step would make it, or leave it.
  struct Corners {
    uint32_t number = 0;  ///< in the changing mesh
    std::array<Eigen::Vector3f, 3> at_m;
  };
  struct Step {
    std::vector<uint32_t> replaced;  ///< triangles that vanish or become others
    Eigen::Vector3f vanishes_m;      ///< the vertex that they have in common
    bool fills_the_ring = false;     ///< whether `made` is over the same ground as `replaced`
    std::vector<Corners> made;       ///< what these become
    std::vector<Corners> beside;     ///< unchanged ones that may be nearest to what vanishes
  };

  /// @param original  outlives this; the changing mesh begins with triangles of the same numbers
  /// @param begins_off_m  how far each is from it then; less than 0: it is not there
  SurfaceBound(const TriangleMesh& original,
               const std::vector<float>& begins_off_m,
               float limit_m,
               float sample_m2);

  /// Whether every sample stays within the limit.
  bool allows(const Step& step);
  /// Takes the step that was allowed last.
  void take(const Step& step);

  const MeshDistance& to_original() const { return to_original_; }
  /// Largest distance from a sample of the original to its triangle.
  /// @param triangles  of the changed mesh, by number
  double largest_m(const std::vector<std::array<Eigen::Vector3f, 3>>& triangles) const;

 private:
  static constexpr uint32_t kNone = ~0U;

  struct Sample {
    Eigen::Vector3f at_m;
    uint32_t next;  ///< of the same triangle
  };
  /// What finds a point's foot on the plane of a triangle; in double as squared_distance().
  struct Foot {
    explicit Foot(const Corners& corners);
    /// Distance to the plane where the foot lies in the triangle, else infinite.
    float above_m(const Eigen::Vector3f& point_m) const;

    Eigen::Vector3d at_m, normal, to_second, to_third;  ///< `to_`: shares of the corners' edges
  };

  void add_sample(const Eigen::Vector3f& point_m, std::size_t triangle);
  bool is_covered(const Step& step);
  uint32_t nearest(const Step& step, const Eigen::Vector3f& point_m) const;
  bool is_on_original(const Step& step);
  bool is_sampled_on_original(const Corners& triangle) const;

  float limit_m_, sample_m2_;
  MeshDistance to_original_;
  std::vector<Sample> samples_;
  std::vector<uint32_t> first_;  ///< sample of each triangle
  std::vector<float> off_m_;     ///< of each triangle: how far it is from the original at most
  std::vector<std::pair<uint32_t, uint32_t>> moved_;  ///< samples and their triangles after a step
  float made_off_m_ = 0.0F;                           ///< how far the step's triangles are
  std::vector<Foot> feet_;                            ///< of the step's triangles
};

}  // namespace marco::mapping3d
