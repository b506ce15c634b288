#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace marco {

/// Triangles with shared vertices, as written, sent and drawn. Float: a millimetre at 8 km.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices_m;         ///< in the frame its owner names
  std::vector<Eigen::Vector3f> normals;            ///< empty or one per vertex, unit length
  std::vector<std::array<uint8_t, 3>> colors_rgb;  ///< empty or one per vertex
  std::vector<std::array<uint32_t, 3>> triangles;  ///< counter-clockwise from the visible side
};

}  // namespace marco
