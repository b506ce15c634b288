#include "viewer/gl_program.hpp"

#include <array>
#include <stdexcept>

namespace marco::viewer {

GlProgram::GlProgram(const GlFunctions& gl,
                     const std::string& defines,
                     const char* vertex_text,
                     const char* fragment_text)
    : gl_(gl), program_(gl.create_program()) {
  const std::string head = "#version 330 core\n" + defines;
  const GLuint vertex = compile(GL_VERTEX_SHADER, head + vertex_text);
  const GLuint fragment = compile(GL_FRAGMENT_SHADER, head + fragment_text);
  gl_.attach_shader(program_, vertex);
  gl_.attach_shader(program_, fragment);
  gl_.link_program(program_);
  gl_.delete_shader(vertex);
  gl_.delete_shader(fragment);
  GLint linked = GL_FALSE;
  gl_.get_program_iv(program_, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return;
  std::array<char, 2048> words{};
  gl_.get_program_info_log(program_, words.size(), nullptr, words.data());
  gl_.delete_program(program_);
  throw std::logic_error(std::string("shaders do not link: ") + words.data());
}

GlProgram::~GlProgram() { gl_.delete_program(program_); }

GLuint GlProgram::compile(GLenum kind, const std::string& text) const {
  const GLuint shader = gl_.create_shader(kind);
  const char* begin = text.c_str();
  gl_.shader_source(shader, 1, &begin, nullptr);
  gl_.compile_shader(shader);
  GLint compiled = GL_FALSE;
  gl_.get_shader_iv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  std::array<char, 2048> words{};
  gl_.get_shader_info_log(shader, words.size(), nullptr, words.data());
  throw std::logic_error(std::string("a shader does not compile: ") + words.data());
}

void GlProgram::use() const { gl_.use_program(program_); }

GLint GlProgram::location(const char* name) const {
  return gl_.get_uniform_location(program_, name);
}

void GlProgram::set(const char* name, const Eigen::Matrix4d& value) const {
  const Eigen::Matrix4f floats = value.cast<float>();
  gl_.uniform_matrix_4fv(location(name), 1, GL_FALSE, floats.data());
}
void GlProgram::set(const char* name, const Eigen::Vector3d& value) const {
  const Eigen::Vector3f floats = value.cast<float>();
  gl_.uniform_3f(location(name), floats.x(), floats.y(), floats.z());
}
void GlProgram::set(const char* name, const Eigen::Vector2d& value) const {
  const Eigen::Vector2f floats = value.cast<float>();
  gl_.uniform_2f(location(name), floats.x(), floats.y());
}
void GlProgram::set(const char* name, double value) const {
  gl_.uniform_1f(location(name), static_cast<float>(value));
}
void GlProgram::set_texture(const char* name, int unit) const {
  gl_.uniform_1i(location(name), unit);
}

}  // namespace marco::viewer
