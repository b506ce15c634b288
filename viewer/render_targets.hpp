#pragma once

#include <memory>

#include "viewer/gl_functions.hpp"

namespace marco::viewer {

/// A texture to draw into. Lives no longer than the context its functions belong to.
class RenderTarget {
 public:
  enum class Kind { color, color_with_depth, openness };

  /// @throws std::runtime_error when the driver has no memory for it.
  RenderTarget(const GlFunctions& gl, Kind kind, int width_px, int height_px);
  ~RenderTarget();
  RenderTarget(const RenderTarget&) = delete;
  RenderTarget& operator=(const RenderTarget&) = delete;

  /// Subsequent draws go to the whole of it.
  void bind() const;
  GLuint framebuffer() const { return framebuffer_; }
  GLuint color_texture() const { return color_; }
  GLuint depth_texture() const { return depth_; }
  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }

 private:
  GLuint make_texture(GLint internal_format, GLenum format, GLenum type) const;
  const GlFunctions& gl_;
  int width_px_;
  int height_px_;
  GLuint framebuffer_ = 0;
  GLuint color_ = 0;
  GLuint depth_ = 0;
};

/// The slot's target; replaced when it is empty or has another size.
const RenderTarget& fitting_target(const GlFunctions& gl,
                                   std::unique_ptr<RenderTarget>& slot,
                                   RenderTarget::Kind kind,
                                   int width_px,
                                   int height_px);

}  // namespace marco::viewer
