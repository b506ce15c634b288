#include "viewer/gl_context.hpp"

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/base/check.hpp"

namespace marco::viewer {
namespace {

struct ContextKind {
  std::string_view name;
  std::unique_ptr<GlContext> (*make)();
};

std::vector<ContextKind> built_in_kinds() {
  return {
#ifdef MARCO_HAS_OSMESA
      {"osmesa", make_osmesa_context},
#endif
#ifdef MARCO_HAS_EGL
      {"egl", make_egl_context},
#endif
  };
}

}  // namespace

void GlContext::load(AnyFunction (*find)(const char* name)) {
  const auto found = [find](const char* name) {
    const AnyFunction function = find(name);
    if (function == nullptr) throw std::runtime_error(std::string("OpenGL lacks ") + name);
    return function;
  };
#define MARCO_GL_LOAD(type, name, gl_name) gl_.name = reinterpret_cast<type>(found(gl_name));
  MARCO_GL_FUNCTIONS(MARCO_GL_LOAD)
#undef MARCO_GL_LOAD
  gl_.get_integer_v(GL_MAX_RENDERBUFFER_SIZE, &max_size_px_);
}

std::unique_ptr<GlContext> make_gl_context() {
  const char* wanted = std::getenv("MARCO_OPENGL");
  std::string names, failures;
  for (const ContextKind& kind : built_in_kinds()) {
    names += (names.empty() ? "" : ", ") + std::string(kind.name);
    if (wanted != nullptr && kind.name != wanted) continue;
    try {
      return kind.make();
    } catch (const std::runtime_error& failure) {
      failures += (failures.empty() ? "" : "; ") + std::string(failure.what());
    }
  }
  require(!failures.empty(), "MARCO_OPENGL=" + std::string(wanted == nullptr ? "" : wanted) +
                                 ": this build has " + names);
  throw std::runtime_error("cannot draw: " + failures);
}

}  // namespace marco::viewer
