#pragma once

#include <GL/glcorearb.h>

// The functions of OpenGL 3.3 the renderer calls: type, our name, OpenGL's name.
#define MARCO_GL_FUNCTIONS(F)                                                                  \
  F(PFNGLACTIVETEXTUREPROC, active_texture, "glActiveTexture")                                 \
  F(PFNGLATTACHSHADERPROC, attach_shader, "glAttachShader")                                    \
  F(PFNGLBINDBUFFERPROC, bind_buffer, "glBindBuffer")                                          \
  F(PFNGLBINDFRAMEBUFFERPROC, bind_framebuffer, "glBindFramebuffer")                           \
  F(PFNGLBINDTEXTUREPROC, bind_texture, "glBindTexture")                                       \
  F(PFNGLBINDVERTEXARRAYPROC, bind_vertex_array, "glBindVertexArray")                          \
  F(PFNGLBLITFRAMEBUFFERPROC, blit_framebuffer, "glBlitFramebuffer")                           \
  F(PFNGLBUFFERDATAPROC, buffer_data, "glBufferData")                                          \
  F(PFNGLCHECKFRAMEBUFFERSTATUSPROC, check_framebuffer_status, "glCheckFramebufferStatus")     \
  F(PFNGLCLEARPROC, clear, "glClear")                                                          \
  F(PFNGLCLEARCOLORPROC, clear_color, "glClearColor")                                          \
  F(PFNGLCOMPILESHADERPROC, compile_shader, "glCompileShader")                                 \
  F(PFNGLCREATEPROGRAMPROC, create_program, "glCreateProgram")                                 \
  F(PFNGLCREATESHADERPROC, create_shader, "glCreateShader")                                    \
  F(PFNGLCULLFACEPROC, cull_face, "glCullFace")                                                \
  F(PFNGLDELETEBUFFERSPROC, delete_buffers, "glDeleteBuffers")                                 \
  F(PFNGLDELETEFRAMEBUFFERSPROC, delete_framebuffers, "glDeleteFramebuffers")                  \
  F(PFNGLDELETEPROGRAMPROC, delete_program, "glDeleteProgram")                                 \
  F(PFNGLDELETESHADERPROC, delete_shader, "glDeleteShader")                                    \
  F(PFNGLDELETETEXTURESPROC, delete_textures, "glDeleteTextures")                              \
  F(PFNGLDELETEVERTEXARRAYSPROC, delete_vertex_arrays, "glDeleteVertexArrays")                 \
  F(PFNGLDISABLEPROC, disable, "glDisable")                                                    \
  F(PFNGLDRAWARRAYSPROC, draw_arrays, "glDrawArrays")                                          \
  F(PFNGLDRAWELEMENTSPROC, draw_elements, "glDrawElements")                                    \
  F(PFNGLENABLEPROC, enable, "glEnable")                                                       \
  F(PFNGLENABLEVERTEXATTRIBARRAYPROC, enable_vertex_attrib_array, "glEnableVertexAttribArray") \
  F(PFNGLFINISHPROC, finish, "glFinish")                                                       \
  F(PFNGLFRAMEBUFFERTEXTURE2DPROC, framebuffer_texture_2d, "glFramebufferTexture2D")           \
  F(PFNGLGENBUFFERSPROC, gen_buffers, "glGenBuffers")                                          \
  F(PFNGLGENFRAMEBUFFERSPROC, gen_framebuffers, "glGenFramebuffers")                           \
  F(PFNGLGENTEXTURESPROC, gen_textures, "glGenTextures")                                       \
  F(PFNGLGENVERTEXARRAYSPROC, gen_vertex_arrays, "glGenVertexArrays")                          \
  F(PFNGLGETERRORPROC, get_error, "glGetError")                                                \
  F(PFNGLGETINTEGERVPROC, get_integer_v, "glGetIntegerv")                                      \
  F(PFNGLGETPROGRAMINFOLOGPROC, get_program_info_log, "glGetProgramInfoLog")                   \
  F(PFNGLGETPROGRAMIVPROC, get_program_iv, "glGetProgramiv")                                   \
  F(PFNGLGETSHADERINFOLOGPROC, get_shader_info_log, "glGetShaderInfoLog")                      \
  F(PFNGLGETSHADERIVPROC, get_shader_iv, "glGetShaderiv")                                      \
  F(PFNGLGETUNIFORMLOCATIONPROC, get_uniform_location, "glGetUniformLocation")                 \
  F(PFNGLLINEWIDTHPROC, line_width, "glLineWidth")                                             \
  F(PFNGLLINKPROGRAMPROC, link_program, "glLinkProgram")                                       \
  F(PFNGLPIXELSTOREIPROC, pixel_store_i, "glPixelStorei")                                      \
  F(PFNGLPOLYGONMODEPROC, polygon_mode, "glPolygonMode")                                       \
  F(PFNGLREADPIXELSPROC, read_pixels, "glReadPixels")                                          \
  F(PFNGLSHADERSOURCEPROC, shader_source, "glShaderSource")                                    \
  F(PFNGLTEXIMAGE2DPROC, tex_image_2d, "glTexImage2D")                                         \
  F(PFNGLTEXPARAMETERIPROC, tex_parameter_i, "glTexParameteri")                                \
  F(PFNGLUNIFORM1FPROC, uniform_1f, "glUniform1f")                                             \
  F(PFNGLUNIFORM1IPROC, uniform_1i, "glUniform1i")                                             \
  F(PFNGLUNIFORM2FPROC, uniform_2f, "glUniform2f")                                             \
  F(PFNGLUNIFORM3FPROC, uniform_3f, "glUniform3f")                                             \
  F(PFNGLUNIFORMMATRIX4FVPROC, uniform_matrix_4fv, "glUniformMatrix4fv")                       \
  F(PFNGLUSEPROGRAMPROC, use_program, "glUseProgram")                                          \
  F(PFNGLVERTEXATTRIBPOINTERPROC, vertex_attrib_pointer, "glVertexAttribPointer")              \
  F(PFNGLVIEWPORTPROC, viewport, "glViewport")

namespace marco::viewer {

/// OpenGL's functions by our names, as one context gives them.
struct GlFunctions {
#define MARCO_GL_MEMBER(type, name, gl_name) type name = nullptr;
  MARCO_GL_FUNCTIONS(MARCO_GL_MEMBER)
#undef MARCO_GL_MEMBER
};

}  // namespace marco::viewer
