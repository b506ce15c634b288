#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "viewer/gl_functions.hpp"

namespace marco::viewer {

/// OpenGL 3.3 core in memory: no display, no graphics card. Pictures of any size up to max_size_px
/// are drawn into framebuffer objects; the context's own surface is a single pixel.
/// Belongs to the thread that made it; one context is current a thread, the last one activated.
class OsmesaContext {
 public:
  /// @throws std::runtime_error saying what to install when there is no OpenGL 3.3.
  OsmesaContext();
  ~OsmesaContext();
  OsmesaContext(const OsmesaContext&) = delete;
  OsmesaContext& operator=(const OsmesaContext&) = delete;

  /// Makes it this thread's current context. @throws std::runtime_error when Mesa refuses.
  void activate();

  const GlFunctions& gl() const { return gl_; }
  /// Of a picture's side.
  int max_size_px() const { return max_size_px_; }
  /// Mesa's name of the renderer, for reports.
  const std::string& renderer_name() const { return renderer_name_; }

 private:
  struct Destroyer {
    void operator()(void* context) const;
  };
  std::unique_ptr<void, Destroyer> context_;
  std::vector<uint8_t> surface_;
  GlFunctions gl_;
  int max_size_px_ = 0;
  std::string renderer_name_;
};

}  // namespace marco::viewer
