#pragma once

#include <Eigen/Core>
#include <string>

#include "viewer/gl_functions.hpp"

namespace marco::viewer {

/// A linked shader program. Lives no longer than the context its functions belong to.
class GlProgram {
 public:
  /// @param defines lines put behind `#version 330 core` of both texts.
  /// @throws std::logic_error with the compiler's words: the texts are ours.
  GlProgram(const GlFunctions& gl,
            const std::string& defines,
            const char* vertex_text,
            const char* fragment_text);
  ~GlProgram();
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const;
  /// Uniforms of the program in use; names the compiler optimized away are ignored.
  void set(const char* name, const Eigen::Matrix4d& value) const;
  void set(const char* name, const Eigen::Vector3d& value) const;
  void set(const char* name, const Eigen::Vector2d& value) const;
  void set(const char* name, double value) const;
  void set_texture(const char* name, int unit) const;

 private:
  GLuint compile(GLenum kind, const std::string& text) const;
  GLint location(const char* name) const;
  const GlFunctions& gl_;
  GLuint program_ = 0;
};

}  // namespace marco::viewer
