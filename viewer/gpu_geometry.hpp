#pragma once

#include "viewer/gl_functions.hpp"
#include "viewer/scene_geometry.hpp"

namespace marco::viewer {

/// Vertices and indices held by the driver. Lives no longer than the context its functions belong
/// to.
class GpuGeometry {
 public:
  GpuGeometry(const GlFunctions& gl, const Geometry& geometry);
  ~GpuGeometry();
  GpuGeometry(const GpuGeometry&) = delete;
  GpuGeometry& operator=(const GpuGeometry&) = delete;

  /// @param primitive GL_TRIANGLES, GL_LINES or GL_POINTS, as the indices were meant.
  void draw(GLenum primitive) const;
  /// Other indices of the same vertices from now on.
  void set_indices(const std::vector<uint32_t>& indices);
  /// Every vertex as a point, whatever the indices join.
  void draw_vertices() const;
  GLsizei index_count() const { return index_count_; }

 private:
  const GlFunctions& gl_;
  GLuint array_ = 0;
  GLuint vertices_ = 0;
  GLuint indices_ = 0;
  GLsizei vertex_count_;
  GLsizei index_count_;
};

}  // namespace marco::viewer
