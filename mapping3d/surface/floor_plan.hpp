#pragma once

#include <vector>

#include "common/triangle_mesh.hpp"

namespace marco::mapping3d {

/// The cut of a mesh at a height, as chains of points [m]; a closed chain repeats its first point.
std::vector<std::vector<Eigen::Vector2d>> cut_at(const TriangleMesh& mesh, double height_m);

}  // namespace marco::mapping3d
