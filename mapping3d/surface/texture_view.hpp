#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "mapping3d/surface/texture.hpp"

namespace marco::mapping3d {

/// What a picture shows of a point.
struct Look {
  Eigen::Vector3f rgb = Eigen::Vector3f::Zero();  ///< 0 to 255, between pixels linear
  float merit = 0.0F;                             ///< above 0, more is better; see TextureView
  uint32_t view = 0;
};

/// A picture with the depth buffer of a mesh. A look's merit is cos^2 / distance^2, faded out
/// towards the picture's border and towards edges of the depth buffer, where a small error of the
/// pose shows another surface (border masks of Callieri, Cignoni, Corsini and Scopigno, Masked
/// Photo Blending, Computers & Graphics 2008). Refers to the picture; const members are safe from
/// several threads. Takes 5 bytes per pixel besides the picture's 3.
class TextureView {
 public:
  /// @param picture  with pixels, a focal length and a finite pose
  TextureView(const CameraPicture& picture,
              const TriangleMesh& mesh,
              const TextureOptions& options,
              uint32_t number);

  /// False only if no point of the triangle can be in the picture, from in front.
  bool may_see(const std::array<Eigen::Vector3f, 3>& corners_m) const;

  /// @param normal  of the surface, unit length. @returns nothing where the point is outside of
  /// the picture, too slanted or hidden: something of the mesh lies more than `hidden_m` in front
  /// of the point's plane, at its pixel or at one of the eight around it.
  std::optional<Look> look_at(const Eigen::Vector3f& point_m, const Eigen::Vector3f& normal) const;

 private:
  int buffer_width() const;
  int buffer_height() const;
  Eigen::Vector2f buffer_place(const Eigen::Vector2f& ideal) const;
  Eigen::Vector2f distorted(const Eigen::Vector2f& ideal) const;
  void find_ideal_radius();
  void draw(const std::array<Eigen::Vector3f, 3>& corners, int deep);
  void find_edges();
  bool is_edge(std::size_t pixel, std::size_t step) const;
  bool hidden(int x, int y, const Eigen::Vector3f& in_camera, const Eigen::Vector3f& normal) const;
  Eigen::Vector3f colour(const Eigen::Vector2f& pixel) const;

  const CameraPicture& picture_;
  uint32_t number_;
  float hidden_m_;
  float min_cosine_;
  Eigen::Isometry3f camera_from_world_;
  Eigen::Vector3f centre_m_;
  float ideal_radius_ = 0.0F;          // of the picture's farthest corner, before distortion
  std::vector<float> depths_m_;        // of an undistorted pinhole, with a margin
  std::vector<uint8_t> from_edge_px_;  // chessboard distance to the nearest edge, up to a limit
};

}  // namespace marco::mapping3d
