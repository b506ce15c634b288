#pragma once

#include <memory>

#include "viewer/gl_functions.hpp"

namespace marco::viewer {

/// OpenGL 3.3 core on the CPU, without display or graphics card. Draws into framebuffer objects of
/// up to max_size_px(); the context has no surface of its own. To be used on the thread that
/// constructed it; the last activated context is the current one of a thread.
class GlContext {
 public:
  GlContext() = default;
  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Makes it this thread's current context. @throws std::runtime_error when the driver refuses.
  virtual void activate() = 0;

  const GlFunctions& gl() const { return gl_; }
  /// Largest side of a picture.
  int max_size_px() const { return max_size_px_; }

 protected:
  using AnyFunction = void (*)();
  /// Takes OpenGL's functions and limits from the current context.
  /// @throws std::runtime_error naming a function that is missing.
  void load(AnyFunction (*find)(const char* name));

 private:
  GlFunctions gl_;
  int max_size_px_ = 0;
};

/// By OSMesa, or else by EGL without a surface, whichever this build found. The environment
/// variable MARCO_OPENGL=osmesa or =egl selects one.
/// @throws std::runtime_error naming what to install when there is no OpenGL 3.3.
std::unique_ptr<GlContext> make_gl_context();

/// Defined where its library was found. @throws std::runtime_error naming what to install.
std::unique_ptr<GlContext> make_osmesa_context();
std::unique_ptr<GlContext> make_egl_context();

}  // namespace marco::viewer
