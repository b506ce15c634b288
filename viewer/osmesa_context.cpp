#include "viewer/osmesa_context.hpp"

#include <GL/osmesa.h>

#include <stdexcept>

namespace marco::viewer {
namespace {

constexpr const char* kRemedy = " (install libosmesa6, Mesa 10 or newer, built with llvmpipe)";

OSMesaContext osmesa(void* context) { return static_cast<OSMesaContext>(context); }

template <class Function>
Function find(const char* name) {
  const auto function = reinterpret_cast<Function>(OSMesaGetProcAddress(name));
  if (function == nullptr) throw std::runtime_error(std::string("OSMesa lacks ") + name + kRemedy);
  return function;
}

}  // namespace

OsmesaContext::OsmesaContext() : surface_(4) {
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
    throw std::runtime_error(std::string("OSMesa gives no OpenGL 3.3 core context") + kRemedy);
  activate();
#define MARCO_GL_LOAD(type, name, gl_name) gl_.name = find<type>(gl_name);
  MARCO_GL_FUNCTIONS(MARCO_GL_LOAD)
#undef MARCO_GL_LOAD
  gl_.get_integer_v(GL_MAX_RENDERBUFFER_SIZE, &max_size_px_);
  renderer_name_ = reinterpret_cast<const char*>(gl_.get_string(GL_RENDERER));
}

OsmesaContext::~OsmesaContext() = default;

void OsmesaContext::Destroyer::operator()(void* context) const {
  OSMesaDestroyContext(osmesa(context));
}

void OsmesaContext::activate() {
  if (OSMesaGetCurrentContext() == osmesa(context_.get())) return;
  if (OSMesaMakeCurrent(osmesa(context_.get()), surface_.data(), GL_UNSIGNED_BYTE, 1, 1) != GL_TRUE)
    throw std::runtime_error("OSMesa refused to make its context current");
}

}  // namespace marco::viewer
