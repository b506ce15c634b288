#pragma once

#include <string>

#include "viewer/model_picture.hpp"

namespace marco::viewer {

enum class VectorFormat { eps, svg, pdf };

struct VectorReport {
  std::size_t polygons = 0;  ///< handed to gl2ps
  std::size_t lines = 0;
};

/// Writes a scene as polygons and lines that stay sharp at any size, by gl2ps without an OpenGL
/// context (with a core profile gl2ps writes an empty file). Triangles are lit flat, sorted from
/// far to near and not cut at one another: what passes through another may show through. Occlusion
/// shadow and supersampling of the look mean nothing here; faint back faces are hidden. Mode points
/// draws one dot per vertex. One call at a time in a process: gl2ps keeps its state in a global.
/// @param size of the page, one unit per pixel.
/// @throws std::runtime_error naming the path when it cannot be written or the disk is full.
VectorReport write_vector(const Scene& scene,
                          const ViewPlan& plan,
                          PictureSize size,
                          VectorFormat format,
                          const std::string& path);

/// From a path's ending. @throws std::invalid_argument unless it is .eps, .svg or .pdf.
VectorFormat vector_format(const std::string& path);

}  // namespace marco::viewer
