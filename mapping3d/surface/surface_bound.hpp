#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "common/mesh_distance.hpp"
#include "common/triangle_mesh.hpp"

namespace marco::mapping3d {

/// Keeps a mesh that changes step by step within a distance of what it was, both ways. Samples and
/// vertices of the original each know a triangle of the changing mesh that lies within the limit of
/// them (as Ciampalini and others, The Visual Computer 1997); triangles that a step makes are
/// sampled against the original. Most of a building is flat, and a step within a plane leaves its
/// surface where it is: what lies on a plane is sampled only once a step would take it away.
class SurfaceBound {
 public:
  /// A triangle as a step would make it, or leave it.
  struct Corners {
    uint32_t number = 0;  ///< in the changing mesh
    std::array<Eigen::Vector3f, 3> at_m;
  };
  struct Step {
    std::vector<Corners> replaced;  ///< triangles that vanish or become others, as they are
    Eigen::Vector3f vanishes_m;     ///< the vertex that they have in common
    bool fills_the_ring = false;    ///< whether `made` is over the same ground as `replaced`
    bool stays_on_plane = false;    ///< whether both lie on one plane, and no triangle is turned
    std::vector<Corners> made;      ///< what these become
    std::vector<Corners> beside;    ///< unchanged ones that may be nearest to what vanishes
  };

  /// @param original  outlives this; the changing mesh begins with triangles of the same numbers
  /// @param begins_off_m  how far each is from it then; less than 0: it is not there
  /// @param on_plane  whether each begins with its corners laid on one plane; empty: none
  SurfaceBound(const TriangleMesh& original,
               std::vector<float> begins_off_m,
               const std::vector<uint8_t>& on_plane,
               float limit_m,
               float sample_m2);

  /// Whether every sample stays within the limit.
  bool allows(const Step& step);
  /// Takes the step that was allowed last.
  void take(const Step& step);

  const MeshDistance& to_original() const { return to_original_; }
  /// Largest distance from a sample of the original to its triangle.
  /// @param corners_m  of a triangle of the changed mesh, by its number
  double largest_m(
      const std::function<std::array<Eigen::Vector3f, 3>(std::size_t)>& corners_m) const;

 private:
  static constexpr uint32_t kNone = ~0U;
  static constexpr uint32_t kOnPlane = kNone - 1;  ///< instead of samples

  struct Sample {
    Eigen::Vector3f at_m;
    float off_m;    ///< of the original: more than 0 where a plane stood for it
    uint32_t next;  ///< of the same triangle
  };
  /// What finds a point's foot on the plane of a triangle; in double as squared_distance().
  struct Foot {
    explicit Foot(const Corners& corners);
    /// Distance to the plane where the foot lies in the triangle, else infinite.
    float above_m(const Eigen::Vector3f& point_m) const;

    Eigen::Vector3d at_m, normal, to_second, to_third;  ///< `to_`: shares of the corners' edges
  };

  void add_sample(const Eigen::Vector3f& point_m, float off_m, std::size_t triangle);
  void sample_plane(const Corners& triangle);
  bool is_plane_filled(const Step& step);
  bool is_covered(const Step& step);
  uint32_t nearest(const Step& step, const Eigen::Vector3f& point_m, float limit_m) const;
  bool is_on_original(const Step& step);
  bool is_sampled_on_original(const Corners& triangle) const;

  float limit_m_, sample_m2_;
  MeshDistance to_original_;
  std::deque<Sample> samples_;   ///< many, and more while planes are cut
  std::vector<uint32_t> first_;  ///< sample of each triangle; kNone, or kOnPlane
  std::vector<float> off_m_;     ///< of each triangle: how far it is from the original at most
  std::vector<std::pair<uint32_t, uint32_t>> moved_;  ///< samples and their triangles after a step
  float made_off_m_ = 0.0F;                           ///< how far the step's triangles are
  bool made_on_plane_ = false;                        ///< and whether a plane stands for them
  std::vector<Foot> feet_;                            ///< of the step's triangles
};

}  // namespace marco::mapping3d
