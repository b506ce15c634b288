#pragma once

#include <memory>
#include <string>

#include "viewer/gl_functions.hpp"

namespace marco::viewer {

/// OpenGL 3.3 core in memory, drawn by the processor: no display, no graphics card. Pictures of any
/// size up to max_size_px() are drawn into framebuffer objects; the context has no surface of its
/// own to speak of. Belongs to the thread that made it; one context is current a thread, the last
/// one activated.
class GlContext {
 public:
  GlContext() = default;
  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Makes it this thread's current context. @throws std::runtime_error when the driver refuses.
  virtual void activate() = 0;

  const GlFunctions& gl() const { return gl_; }
  /// Of a picture's side.
  int max_size_px() const { return max_size_px_; }
  /// The driver's name of itself, for reports.
  const std::string& renderer_name() const { return renderer_name_; }

 protected:
  using AnyFunction = void (*)();
  /// Takes OpenGL's functions and limits from the current context.
  /// @throws std::runtime_error naming a function that is missing.
  void load(AnyFunction (*find)(const char* name));

 private:
  GlFunctions gl_;
  int max_size_px_ = 0;
  std::string renderer_name_;
};

/// Through OSMesa, or, where that is missing, through EGL without a surface, as this build found
/// them. The environment variable MARCO_OPENGL=osmesa or =egl allows only that one.
/// @throws std::runtime_error saying what to install when there is no OpenGL 3.3.
std::unique_ptr<GlContext> make_gl_context();

/// Each exists where its library was found. @throws std::runtime_error saying what to install.
std::unique_ptr<GlContext> make_osmesa_context();
std::unique_ptr<GlContext> make_egl_context();

}  // namespace marco::viewer
