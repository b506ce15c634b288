#define EGL_NO_X11  // its headers would define names as common as None and Success
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <cstring>
#include <stdexcept>

#include "lcm_tools/base/format.hpp"
#include "viewer/gl_context.hpp"

namespace marco::viewer {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what +
                           format(" (EGL error 0x%x)", static_cast<unsigned>(eglGetError())));
}

bool has(const char* extensions, const char* name) {
  return extensions != nullptr && std::strstr(extensions, name) != nullptr;
}

// The software device: a graphics card would draw slightly different pictures.
EGLDisplay software_display() {
  const auto query_devices =
      reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  const auto query_string = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(
      eglGetProcAddress("eglQueryDeviceStringEXT"));
  std::array<EGLDeviceEXT, 32> devices{};
  EGLint count = 0;
  if (query_devices == nullptr || query_string == nullptr ||
      query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) != EGL_TRUE)
    fail("EGL lists no devices; install libegl1 and libgl1-mesa-dri");
  for (EGLint i = 0; i < count; ++i)
    if (has(query_string(devices[static_cast<std::size_t>(i)], EGL_EXTENSIONS),
            "EGL_MESA_device_software"))
      return eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)],
                                   nullptr);
  fail("EGL has no software device; install libegl-mesa0 and libgl1-mesa-dri");
}

class EglContext : public GlContext {
 public:
  EglContext() : display_(software_display()) {
    if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) != EGL_TRUE)
      fail("EGL's software device does not start; install libgl1-mesa-dri");
    if (!has(eglQueryString(display_, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context") ||
        eglBindAPI(EGL_OPENGL_API) != EGL_TRUE)
      fail("EGL gives no OpenGL without a surface; Mesa 10 or newer does");
    constexpr EGLint kAttributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                      3,
                                      EGL_CONTEXT_MINOR_VERSION,
                                      3,
                                      EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                      EGL_NONE};
    // No config: only framebuffer objects are drawn to, without multisampling.
    context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, kAttributes);
    if (context_ == EGL_NO_CONTEXT) fail("EGL gives no OpenGL 3.3 core context");
    try {
      activate();
      load(eglGetProcAddress);
    } catch (...) {
      release();
      throw;
    }
  }

  // All contexts of the process share the display: it stays open.
  ~EglContext() override { release(); }

  void activate() override {
    if (eglGetCurrentContext() == context_) return;
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE)
      fail("EGL refused to make its context current");
  }

 private:
  void release() {
    if (eglGetCurrentContext() == context_)
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }

  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::unique_ptr<GlContext> make_egl_context() { return std::make_unique<EglContext>(); }

}  // namespace marco::viewer
