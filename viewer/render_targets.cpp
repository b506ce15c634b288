#include "viewer/render_targets.hpp"

#include <stdexcept>
#include <string>

namespace marco::viewer {

RenderTarget::RenderTarget(const GlFunctions& gl, Kind kind, int width_px, int height_px)
    : gl_(gl), width_px_(width_px), height_px_(height_px) {
  color_ = kind == Kind::openness ? make_texture(GL_R8, GL_RED, GL_UNSIGNED_BYTE)
                                  : make_texture(GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE);
  if (kind == Kind::color_with_depth)
    depth_ = make_texture(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT);
  gl_.gen_framebuffers(1, &framebuffer_);
  gl_.bind_framebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.framebuffer_texture_2d(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color_, 0);
  if (depth_ != 0)
    gl_.framebuffer_texture_2d(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_, 0);
  if (gl_.check_framebuffer_status(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw std::runtime_error("OpenGL has no memory for a picture of " + std::to_string(width_px) +
                             " x " + std::to_string(height_px) + " px");
}

RenderTarget::~RenderTarget() {
  gl_.delete_framebuffers(1, &framebuffer_);
  gl_.delete_textures(1, &color_);
  if (depth_ != 0) gl_.delete_textures(1, &depth_);
}

GLuint RenderTarget::make_texture(GLint internal_format, GLenum format, GLenum type) const {
  GLuint texture = 0;
  gl_.gen_textures(1, &texture);
  gl_.bind_texture(GL_TEXTURE_2D, texture);
  gl_.tex_image_2d(GL_TEXTURE_2D, 0, internal_format, width_px_, height_px_, 0, format, type,
                   nullptr);
  gl_.tex_parameter_i(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.tex_parameter_i(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

void RenderTarget::bind() const {
  gl_.bind_framebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.viewport(0, 0, width_px_, height_px_);
}

const RenderTarget& fitting_target(const GlFunctions& gl,
                                   std::unique_ptr<RenderTarget>& slot,
                                   RenderTarget::Kind kind,
                                   int width_px,
                                   int height_px) {
  if (!slot || slot->width_px() != width_px || slot->height_px() != height_px) {
    slot.reset();
    slot = std::make_unique<RenderTarget>(gl, kind, width_px, height_px);
  }
  return *slot;
}

}  // namespace marco::viewer
