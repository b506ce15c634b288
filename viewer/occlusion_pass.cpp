#include "viewer/occlusion_pass.hpp"

#include "viewer/shaders.hpp"

namespace marco::viewer {

OcclusionPass::OcclusionPass(const GlFunctions& gl)
    : gl_(gl),
      occlusion_(gl, "", shaders::kScreenVertex, shaders::kOcclusion),
      blur_(gl, "", shaders::kScreenVertex, shaders::kBlur),
      compose_(gl, "#define COMPOSE\n", shaders::kScreenVertex, shaders::kBlur) {
  gl_.gen_vertex_arrays(1, &no_vertices_);
}

const RenderTarget& OcclusionPass::apply(const RenderTarget& surfaces, const View& view) {
  const int width = surfaces.width_px(), height = surfaces.height_px();
  const int coarse_width = width / view.supersampling, coarse_height = height / view.supersampling;
  const RenderTarget& raw = fitting_target(gl_, openness_target_, RenderTarget::Kind::openness,
                                           coarse_width, coarse_height);
  const RenderTarget& blurred = fitting_target(gl_, blurred_target_, RenderTarget::Kind::openness,
                                               coarse_width, coarse_height);
  const RenderTarget& composed =
      fitting_target(gl_, composed_target_, RenderTarget::Kind::color, width, height);
  gl_.disable(GL_DEPTH_TEST);
  gl_.bind_vertex_array(no_vertices_);
  gl_.active_texture(GL_TEXTURE1);
  gl_.bind_texture(GL_TEXTURE_2D, surfaces.depth_texture());
  gl_.active_texture(GL_TEXTURE2);
  gl_.bind_texture(GL_TEXTURE_2D, surfaces.color_texture());

  for (const GlProgram* program : {&occlusion_, &blur_, &compose_}) {
    program->use();
    program->set("size_px", Eigen::Vector2d(width, height));
  }
  occlusion_.use();
  occlusion_.set("radius_m", view.radius_m);
  occlusion_.set("px_per_m_at_1m", view.px_per_m_at_1m);
  occlusion_.set("perspective", view.perspective ? 1.0 : 0.0);
  blur_.use();
  blur_.set("direction", Eigen::Vector2d(1.0, 0.0));
  compose_.use();
  compose_.set("direction", Eigen::Vector2d(0.0, 1.0));
  run(occlusion_, raw, 0, view);
  run(blur_, blurred, raw.color_texture(), view);
  run(compose_, composed, blurred.color_texture(), view);
  return composed;
}

void OcclusionPass::run(const GlProgram& program,
                        const RenderTarget& to,
                        GLuint input,
                        const View& view) {
  to.bind();
  gl_.active_texture(GL_TEXTURE0);
  gl_.bind_texture(GL_TEXTURE_2D, input);
  program.use();
  program.set_texture("openness_map", 0);
  program.set_texture("depth", 1);
  program.set_texture("colors", 2);
  program.set("camera_from_clip", view.camera_from_clip);
  program.set("stride", static_cast<double>(view.supersampling));
  gl_.draw_arrays(GL_TRIANGLES, 0, 3);
}

}  // namespace marco::viewer
