#include "viewer/gpu_geometry.hpp"

#include <cstddef>

namespace marco::viewer {
namespace {

// OpenGL wants offsets into a buffer as pointers.
const void* offset(std::size_t bytes) {
  return reinterpret_cast<const void*>(bytes);  // NOLINT(performance-no-int-to-ptr)
}

}  // namespace

GpuGeometry::GpuGeometry(const GlFunctions& gl, const Geometry& geometry)
    : gl_(gl),
      vertex_count_(static_cast<GLsizei>(geometry.vertices.size())),
      index_count_(static_cast<GLsizei>(geometry.indices.size())) {
  gl_.gen_vertex_arrays(1, &array_);
  gl_.bind_vertex_array(array_);
  gl_.gen_buffers(1, &vertices_);
  gl_.bind_buffer(GL_ARRAY_BUFFER, vertices_);
  gl_.buffer_data(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertex_count_ * sizeof(Vertex)),
                  geometry.vertices.data(), GL_STATIC_DRAW);
  gl_.gen_buffers(1, &indices_);
  gl_.bind_buffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  gl_.buffer_data(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(index_count_ * sizeof(uint32_t)),
                  geometry.indices.data(), GL_STATIC_DRAW);
  for (GLuint attribute = 0; attribute < 3; ++attribute) gl_.enable_vertex_attrib_array(attribute);
  constexpr GLsizei kStride = sizeof(Vertex);
  gl_.vertex_attrib_pointer(0, 3, GL_FLOAT, GL_FALSE, kStride,
                            offset(offsetof(Vertex, position_m)));
  gl_.vertex_attrib_pointer(1, 4, GL_SHORT, GL_TRUE, kStride, offset(offsetof(Vertex, normal)));
  gl_.vertex_attrib_pointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, kStride,
                            offset(offsetof(Vertex, color)));
}

GpuGeometry::~GpuGeometry() {
  gl_.delete_vertex_arrays(1, &array_);
  gl_.delete_buffers(1, &vertices_);
  gl_.delete_buffers(1, &indices_);
}

void GpuGeometry::draw(GLenum primitive) const {
  if (index_count_ == 0) return;
  gl_.bind_vertex_array(array_);
  gl_.draw_elements(primitive, index_count_, GL_UNSIGNED_INT, nullptr);
}

void GpuGeometry::set_indices(const std::vector<uint32_t>& indices) {
  index_count_ = static_cast<GLsizei>(indices.size());
  gl_.bind_vertex_array(array_);
  gl_.buffer_data(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(index_count_ * sizeof(uint32_t)),
                  indices.data(), GL_STREAM_DRAW);
}

void GpuGeometry::draw_vertices() const {
  if (vertex_count_ == 0) return;
  gl_.bind_vertex_array(array_);
  gl_.draw_arrays(GL_POINTS, 0, vertex_count_);
}

}  // namespace marco::viewer
