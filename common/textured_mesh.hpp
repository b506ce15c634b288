#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/triangle_mesh.hpp"

namespace marco {

/// A mesh with a picture on it.
struct TexturedMesh {
  TriangleMesh mesh;
  std::vector<Eigen::Vector2f> uvs;  ///< one per vertex; (0, 0) is the picture's upper left corner
  std::string image;                 ///< an encoded PNG or JPEG
};

}  // namespace marco
