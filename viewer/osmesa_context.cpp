#include <GL/osmesa.h>

#include <array>
#include <cstdint>
#include <stdexcept>

#include "viewer/gl_context.hpp"

namespace marco::viewer {
namespace {

class OsmesaContext : public GlContext {
 public:
  OsmesaContext() {
    constexpr int kAttributes[] = {OSMESA_FORMAT,
                                   OSMESA_RGBA,
                                   OSMESA_DEPTH_BITS,
                                   0,
                                   OSMESA_PROFILE,
                                   OSMESA_CORE_PROFILE,
                                   OSMESA_CONTEXT_MAJOR_VERSION,
                                   3,
                                   OSMESA_CONTEXT_MINOR_VERSION,
                                   3,
                                   0};
    context_.reset(OSMesaCreateContextAttribs(kAttributes, nullptr));
    if (!context_)
      throw std::runtime_error(
          "OSMesa gives no OpenGL 3.3 core context (install libosmesa6, Mesa 10 or newer, built "
          "with llvmpipe)");
    activate();
    load(OSMesaGetProcAddress);
  }

  void activate() override {
    if (OSMesaGetCurrentContext() == context_.get()) return;
    if (OSMesaMakeCurrent(context_.get(), surface_.data(), GL_UNSIGNED_BYTE, 1, 1) != GL_TRUE)
      throw std::runtime_error("OSMesa refused to make its context current");
  }

 private:
  struct Destroyer {
    void operator()(OSMesaContext context) const { OSMesaDestroyContext(context); }
  };
  std::unique_ptr<osmesa_context, Destroyer> context_;
  std::array<uint8_t, 4> surface_{};  // OSMesa requires one: a pixel
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context() { return std::make_unique<OsmesaContext>(); }

}  // namespace marco::viewer
