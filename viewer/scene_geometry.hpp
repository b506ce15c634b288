#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "viewer/scene.hpp"

namespace marco::viewer {

/// One corner as the graphics driver takes it.
struct Vertex {
  std::array<float, 3> position_m{};
  std::array<int16_t, 4> normal{};  ///< scaled by 32767; all 0 = not lit
  std::array<uint8_t, 4> color{};   ///< red, green, blue, 255

  /// Of length 0 or about 1.
  Eigen::Vector3f unit_normal() const {
    return Eigen::Vector3f(normal[0], normal[1], normal[2]) / 32767.0F;
  }
  /// What is not finite is 0.
  void set_normal(const Eigen::Vector3f& direction);
};
static_assert(sizeof(Vertex) == 24, "the renderer describes this layout to OpenGL");

/// Vertices, and their indices: three per triangle, two per line, one per point.
struct Geometry {
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;
};

/// A scene broken down to what a driver draws.
struct SceneGeometry {
  Geometry surfaces;  ///< triangles of meshes and map: cut, coloured and drawn in the look's mode
  Geometry props;     ///< triangles of walls, robots, paths, ellipses: always filled
  Geometry points;    ///< loose points
  Geometry lines;     ///< rays
};

/// Triangles with an index beyond the vertices or a corner that is not finite are left out.
/// Meshes without normals get them, weighted by area.
SceneGeometry build_geometry(const Scene& scene);

}  // namespace marco::viewer
