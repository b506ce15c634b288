#include "viewer/renderer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "viewer/gl_context.hpp"
#include "viewer/gl_program.hpp"
#include "viewer/render_targets.hpp"
#include "viewer/shaders.hpp"
#include "viewer/surface_pass.hpp"

namespace marco::viewer {
namespace {

constexpr int kLargestPicturePx = 60000;

void check_request(const Look& look, PictureSize size) {
  require(size.width_px >= 1 && size.height_px >= 1 && size.width_px <= kLargestPicturePx &&
              size.height_px <= kLargestPicturePx,
          "a picture of " + std::to_string(size.width_px) + " x " + std::to_string(size.height_px) +
              " px is outside 1..60000 px");
  require(look.supersampling >= 1 && look.supersampling <= 4,
          "supersampling = " + std::to_string(look.supersampling) + " is outside 1..4");
}

}  // namespace

/// Screen-space ambient occlusion: darkens pixels behind nearby surfaces, by the depths that were
/// drawn (shaders.hpp, kOcclusion). Must not outlive the context of its functions.
class OcclusionPass {
 public:
  explicit OcclusionPass(const GlFunctions& gl);

  struct View {
    Eigen::Matrix4d camera_from_clip;  ///< of the target
    double radius_m;                   ///< largest distance of surfaces that darken each other
    double px_per_m_at_1m;             ///< of the target; orthographic: at any distance
    bool perspective;
    int supersampling;  ///< shadows are soft: one sample per finished pixel suffices
  };

  /// @param surfaces colours and depths. @returns the same colours, darkened; good until the next
  /// call.
  const RenderTarget& apply(const RenderTarget& surfaces, const View& view);

 private:
  void run(const GlProgram& program, const RenderTarget& to, GLuint input, const View& view);

  const GlFunctions& gl_;
  GlProgram occlusion_;
  GlProgram blur_;
  GlProgram compose_;
  std::unique_ptr<RenderTarget> openness_target_;
  std::unique_ptr<RenderTarget> blurred_target_;
  std::unique_ptr<RenderTarget> composed_target_;
  GLuint no_vertices_ = 0;
};

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

std::array<double, 2> height_range_m(const Look& look, const Box& box) {
  if (look.height_range_m) return *look.height_range_m;
  if (box.empty()) return {0.0, 1.0};
  return {box.min_m.z(), std::min(box.max_m.z(), look.cut_height_m)};
}

Look thesis_look(Mode mode) {
  Look look;
  look.mode = mode;
  look.coloring = Coloring::grey;
  look.light = Light::thesis;
  look.occlusion_radius_m = 0.0;
  look.background = {12, 12, 16};
  return look;
}

class Renderer::Implementation {
 public:
  void load(const Scene& scene) {
    context_->activate();
    surfaces_.load(scene);
  }

  Picture draw(const Camera& camera, const Look& look, PictureSize size) {
    check_request(look, size);
    context_->activate();
    Picture picture(size.width_px, size.height_px, {});
    const int step =
        (std::min(context_->max_size_px(), kTilePx) - 2 * kOverlapPx) / look.supersampling;
    if (std::max(size.width_px, size.height_px) <= step) {
      render_tile(camera, look, size, whole(look, size));
      read(picture, {0, 0, size.width_px, size.height_px}, 0, 0);
      return picture;
    }
    for (int y = 0; y < size.height_px; y += step)
      for (int x = 0; x < size.width_px; x += step)
        draw_part(camera, look, size,
                  {x, y, std::min(step, size.width_px - x), std::min(step, size.height_px - y)},
                  picture);
    return picture;
  }

  std::vector<float> draw_depth_m(const Camera& camera, const Look& look, PictureSize size) {
    check_request(look, size);
    require(
        std::max(size.width_px, size.height_px) <= context_->max_size_px(),
        "a depth picture cannot be larger than " + std::to_string(context_->max_size_px()) + " px");
    context_->activate();
    Look once = look;
    once.supersampling = 1;
    render_surfaces(camera, once, size, whole(once, size));
    const std::size_t width = size.width_px, height = size.height_px;
    std::vector<float> depths(width * height), rows(width * height);
    gl_.read_pixels(0, 0, size.width_px, size.height_px, GL_DEPTH_COMPONENT, GL_FLOAT,
                    depths.data());
    const Eigen::Matrix4d camera_from_clip = clip_from_camera(camera, size.aspect()).inverse();
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        const float depth = depths[(height - 1 - y) * width + x];
        const Eigen::Vector4d point =
            camera_from_clip *
            Eigen::Vector4d(0.0, 0.0, 2.0 * static_cast<double>(depth) - 1.0, 1.0);
        rows[y * width + x] = depth >= 1.0F ? std::numeric_limits<float>::infinity()
                                            : static_cast<float>(-point.z() / point.w());
      }
    }
    return rows;
  }

  void draw_unread(const Camera& camera, const Look& look, PictureSize size) {
    check_request(look, size);
    context_->activate();
    render_surfaces(camera, look, size, whole(look, size));
    gl_.finish();
  }

  void draw_bare() {
    gl_.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    surfaces_.draw_bare();
    gl_.finish();
  }

  const SurfacePass& surfaces() const { return surfaces_; }

 private:
  // Tiles keep the memory of a large picture small; the overlap lets corners darken each other
  // across a tile's edge.
  static constexpr int kTilePx = 8192;
  static constexpr int kOverlapPx = 256;

  static Tile whole(const Look& look, PictureSize size) {
    return {0, 0, size.width_px * look.supersampling, size.height_px * look.supersampling};
  }

  // @param part of the finished picture, y from the bottom.
  void draw_part(const Camera& camera,
                 const Look& look,
                 PictureSize size,
                 const Tile& part,
                 Picture& picture) {
    const int overlap = kOverlapPx / look.supersampling;
    const Tile wide{part.x - overlap, part.y - overlap, part.width + 2 * overlap,
                    part.height + 2 * overlap};
    const int s = look.supersampling;
    render_tile(camera, look, size, {wide.x * s, wide.y * s, wide.width * s, wide.height * s});
    read(picture, part, overlap, overlap);
  }

  // Surfaces, then their shadows, then the average of the samples: the result is bound for
  // reading.
  void render_tile(const Camera& camera, const Look& look, PictureSize size, const Tile& tile) {
    render_surfaces(camera, look, size, tile);
    const RenderTarget* result =
        &target(surface_target_, RenderTarget::Kind::color_with_depth, tile.width, tile.height);
    if (look.occlusion_radius_m > 0.0)
      result = &occlusion_.apply(*surface_target_, occlusion_view(camera, look, size, tile));
    const int width = tile.width / look.supersampling, height = tile.height / look.supersampling;
    if (look.supersampling == 1) {
      result->bind();
      return;
    }
    // Averages of two by two samples, halved until the size is reached (4 = 2 * 2); 3 takes the
    // nearest four of nine.
    const RenderTarget& last = target(final_target_, RenderTarget::Kind::color, width, height);
    const RenderTarget* from = result;
    if (look.supersampling == 4) {
      const RenderTarget& half =
          target(half_target_, RenderTarget::Kind::color, 2 * width, 2 * height);
      shrink(*from, half);
      from = &half;
    }
    shrink(*from, last);
    last.bind();
  }

  void shrink(const RenderTarget& from, const RenderTarget& to) {
    gl_.bind_framebuffer(GL_READ_FRAMEBUFFER, from.framebuffer());
    gl_.bind_framebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer());
    gl_.blit_framebuffer(0, 0, from.width_px(), from.height_px(), 0, 0, to.width_px(),
                         to.height_px(), GL_COLOR_BUFFER_BIT, GL_LINEAR);
  }

  void render_surfaces(const Camera& camera, const Look& look, PictureSize size, const Tile& tile) {
    target(surface_target_, RenderTarget::Kind::color_with_depth, tile.width, tile.height).bind();
    const Rgb ground = look.background;
    gl_.clear_color(static_cast<float>(ground.red) / 255.0F,
                    static_cast<float>(ground.green) / 255.0F,
                    static_cast<float>(ground.blue) / 255.0F, 1.0F);
    gl_.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    surfaces_.draw(camera, look, size, tile);
  }

  OcclusionPass::View occlusion_view(const Camera& camera,
                                     const Look& look,
                                     PictureSize size,
                                     const Tile& tile) const {
    const int width = size.width_px * look.supersampling;
    const int height = size.height_px * look.supersampling;
    const Eigen::Matrix4d clip = clip_from_camera(camera, size.aspect());
    return {(tile_from_clip(tile, width, height) * clip).inverse(), look.occlusion_radius_m,
            0.5 * clip(1, 1) * height, camera.projection == Projection::perspective,
            look.supersampling};
  }

  // @param part where it goes, y from the bottom; @param x, y where it lies in the bound target.
  void read(Picture& picture, const Tile& part, int x, int y) {
    row_buffer_.resize(4 * static_cast<std::size_t>(part.width) * part.height);
    gl_.read_pixels(x, y, part.width, part.height, GL_RGBA, GL_UNSIGNED_BYTE, row_buffer_.data());
    const uint8_t* from = row_buffer_.data();
    for (int row = 0; row < part.height; ++row) {
      Rgb* to = &picture.at(part.x, picture.height_px - 1 - (part.y + row));
      for (int column = 0; column < part.width; ++column, from += 4)
        to[column] = {from[0], from[1], from[2]};
    }
  }

  const RenderTarget& target(std::unique_ptr<RenderTarget>& slot,
                             RenderTarget::Kind kind,
                             int width,
                             int height) {
    return fitting_target(gl_, slot, kind, width, height);
  }

  std::unique_ptr<GlContext> context_ = make_gl_context();
  const GlFunctions& gl_ = context_->gl();
  OcclusionPass occlusion_{gl_};
  SurfacePass surfaces_{gl_};
  std::unique_ptr<RenderTarget> surface_target_, half_target_, final_target_;
  std::vector<uint8_t> row_buffer_;
};

Renderer::Renderer() : implementation_(std::make_unique<Implementation>()) {}
Renderer::~Renderer() = default;

void Renderer::load(const Scene& scene) { implementation_->load(scene); }
Picture Renderer::draw(const Camera& camera, const Look& look, PictureSize size) {
  return implementation_->draw(camera, look, size);
}
std::vector<float> Renderer::draw_depth_m(const Camera& camera,
                                          const Look& look,
                                          PictureSize size) {
  return implementation_->draw_depth_m(camera, look, size);
}
std::size_t Renderer::triangle_count() const {
  return implementation_->surfaces().triangle_count();
}
const Box& Renderer::box() const { return implementation_->surfaces().box(); }
void Renderer::draw_unread(const Camera& camera, const Look& look, PictureSize size) {
  implementation_->draw_unread(camera, look, size);
}
void Renderer::draw_bare() { implementation_->draw_bare(); }

}  // namespace marco::viewer
