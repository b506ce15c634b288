#include "viewer/surface_pass.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>

#include "viewer/shaders.hpp"
#include "viewer/shading.hpp"

namespace marco::viewer {
namespace {

// OpenGL wants offsets into a buffer as pointers.
const void* offset(std::size_t bytes) {
  return reinterpret_cast<const void*>(bytes);  // NOLINT(performance-no-int-to-ptr)
}

const char* define_of(Coloring coloring) {
  switch (coloring) {
    case Coloring::height:
      return "#define COLOR_HEIGHT\n";
    case Coloring::normal:
      return "#define COLOR_NORMAL\n";
    case Coloring::grey:
      return "#define COLOR_GREY\n";
    case Coloring::scene:
      return "#define COLOR_SCENE\n";
  }
  throw std::logic_error("a coloring without a name");
}

const char* define_of(Light light) {
  return light == Light::thesis ? "#define LIGHT_THESIS\n" : "#define LIGHT_ROOM\n";
}

std::string vec3(const std::array<double, 3>& values) {
  std::string text = "vec3(";
  for (const double value : values) {
    std::array<char, 32> digits{};  // with a point in every locale
    text.append(digits.data(),
                std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
    text += ',';
  }
  text.back() = ')';
  return text;
}

/// The numbers of shading.hpp.
std::string constants() {
  std::string text = "#define HEIGHT_COLORS vec3[](";
  for (const std::array<double, 3>& color : kHeightColors) text.append(vec3(color)) += ',';
  text.back() = ')';
  text.append("\n#define ROOM_LIGHT ").append(vec3({kRoomAmbient, kRoomSky, kRoomLamp}));
  text.append("\n#define THESIS_LIGHT ")
      .append(vec3({kThesisAmbient, kThesisDiffuse, kThesisGrey}));
  return text += '\n';
}

}  // namespace

GpuGeometry::GpuGeometry(const GlFunctions& gl, const Geometry& geometry)
    : gl_(gl),
      vertex_count_(static_cast<GLsizei>(geometry.vertices.size())),
      index_count_(static_cast<GLsizei>(geometry.indices.size())) {
  gl_.gen_vertex_arrays(1, &array_);
  gl_.bind_vertex_array(array_);
  gl_.gen_buffers(1, &vertices_);
  gl_.bind_buffer(GL_ARRAY_BUFFER, vertices_);
  gl_.buffer_data(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertex_count_ * sizeof(Vertex)),
                  geometry.vertices.data(), GL_STATIC_DRAW);
  gl_.gen_buffers(1, &indices_);
  gl_.bind_buffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  gl_.buffer_data(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(index_count_ * sizeof(uint32_t)),
                  geometry.indices.data(), GL_STATIC_DRAW);
  for (GLuint attribute = 0; attribute < 3; ++attribute) gl_.enable_vertex_attrib_array(attribute);
  constexpr GLsizei kStride = sizeof(Vertex);
  gl_.vertex_attrib_pointer(0, 3, GL_FLOAT, GL_FALSE, kStride,
                            offset(offsetof(Vertex, position_m)));
  gl_.vertex_attrib_pointer(1, 4, GL_SHORT, GL_TRUE, kStride, offset(offsetof(Vertex, normal)));
  gl_.vertex_attrib_pointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, kStride,
                            offset(offsetof(Vertex, color)));
}

GpuGeometry::~GpuGeometry() {
  gl_.delete_vertex_arrays(1, &array_);
  gl_.delete_buffers(1, &vertices_);
  gl_.delete_buffers(1, &indices_);
}

void GpuGeometry::draw(GLenum primitive) const {
  if (index_count_ == 0) return;
  gl_.bind_vertex_array(array_);
  gl_.draw_elements(primitive, index_count_, GL_UNSIGNED_INT, nullptr);
}

void GpuGeometry::set_indices(const std::vector<uint32_t>& indices) {
  index_count_ = static_cast<GLsizei>(indices.size());
  gl_.bind_vertex_array(array_);
  gl_.buffer_data(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(index_count_ * sizeof(uint32_t)),
                  indices.data(), GL_STREAM_DRAW);
}

void GpuGeometry::draw_vertices() const {
  if (vertex_count_ == 0) return;
  gl_.bind_vertex_array(array_);
  gl_.draw_arrays(GL_POINTS, 0, vertex_count_);
}

Eigen::Matrix4d tile_from_clip(const Tile& tile, int width, int height) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = static_cast<double>(width) / tile.width;
  matrix(1, 1) = static_cast<double>(height) / tile.height;
  matrix(0, 3) = matrix(0, 0) - 1.0 - 2.0 * tile.x / tile.width;
  matrix(1, 3) = matrix(1, 1) - 1.0 - 2.0 * tile.y / tile.height;
  return matrix;
}

void SurfacePass::load(const Scene& scene) {
  SceneGeometry geometry = build_geometry(scene);
  surfaces_ = std::make_unique<GpuGeometry>(gl_, geometry.surfaces);
  levels_.reset();
  levelled_.reset();
  props_ = std::make_unique<GpuGeometry>(gl_, geometry.props);
  points_ = std::make_unique<GpuGeometry>(gl_, geometry.points);
  lines_ = std::make_unique<GpuGeometry>(gl_, geometry.lines);
  box_ = bounding_box(scene);
  source_ = std::move(geometry.surfaces);
}

std::size_t SurfacePass::triangle_count() const {
  return surfaces_ ? static_cast<std::size_t>(surfaces_->index_count()) / 3 : 0;
}

void SurfacePass::draw(const Camera& camera, const Look& look, PictureSize size, const Tile& tile) {
  gl_.enable(GL_DEPTH_TEST);
  gl_.enable(GL_PROGRAM_POINT_SIZE);
  if (!surfaces_) return;
  gl_.line_width(static_cast<float>(look.supersampling));
  prepare(surface_program(Coloring::scene, look.light, BackFaces::show), camera, look, size, tile)
      .set("cut_height_m", std::numeric_limits<float>::max());
  props_->draw(GL_TRIANGLES);
  points_->draw(GL_POINTS);
  lines_->draw(GL_LINES);
  draw_meshes(camera, look, size, tile);
}

void SurfacePass::draw_meshes(const Camera& camera,
                              const Look& look,
                              PictureSize size,
                              const Tile& tile) {
  const bool cut = std::isfinite(look.cut_height_m);
  prepare(surface_program(look.coloring, look.light, look.back_faces), camera, look, size, tile)
      .set("cut_height_m", cut ? look.cut_height_m : 1e30);
  if (cut) gl_.enable(GL_CLIP_DISTANCE0);
  if (look.back_faces == BackFaces::hide) gl_.enable(GL_CULL_FACE);
  gl_.cull_face(GL_BACK);
  gl_.polygon_mode(GL_FRONT_AND_BACK, look.mode == Mode::wire ? GL_LINE : GL_FILL);
  if (look.mode == Mode::points)
    surfaces_->draw_vertices();
  else if (look.detail_px > 0.0)
    draw_levels(camera, look, size, tile);
  else
    surfaces_->draw(GL_TRIANGLES);
  gl_.polygon_mode(GL_FRONT_AND_BACK, GL_FILL);
  gl_.disable(GL_CULL_FACE);
  gl_.disable(GL_CLIP_DISTANCE0);
}

// Made when first asked for: a single picture is drawn sooner without.
void SurfacePass::draw_levels(const Camera& camera,
                              const Look& look,
                              PictureSize size,
                              const Tile& tile) {
  if (!levels_) {
    levels_ = std::make_unique<DetailLevels>(source_);
    Geometry packed = levels_->packed(source_);
    level_indices_ = std::move(packed.indices);
    levelled_ = std::make_unique<GpuGeometry>(gl_, Geometry{std::move(packed.vertices), {}});
  }
  const int width = size.width_px * look.supersampling;
  const int height = size.height_px * look.supersampling;
  const Eigen::Matrix4d clip = clip_from_camera(camera, size.aspect());
  const DetailLevels::View view{
      tile_from_clip(tile, width, height) * clip * camera_from_world(camera), camera.eye_m,
      0.5 * clip(1, 1) * size.height_px, camera.projection == Projection::perspective,
      look.detail_px};
  // One call: what a driver does for each costs as much as hundreds of triangles.
  chosen_.clear();
  for (const DetailLevels::Range& range : levels_->choose(view)) {
    const auto from = level_indices_.begin() + static_cast<std::ptrdiff_t>(range.first);
    chosen_.insert(chosen_.end(), from, from + static_cast<std::ptrdiff_t>(range.count));
  }
  levelled_->set_indices(chosen_);
  levelled_->draw(GL_TRIANGLES);
}

const GlProgram& SurfacePass::prepare(const GlProgram& program,
                                      const Camera& camera,
                                      const Look& look,
                                      PictureSize size,
                                      const Tile& tile) {
  program.use();
  const Eigen::Matrix4d from_world = camera_from_world(camera);
  const Eigen::Matrix4d clip = tile_from_clip(tile, size.width_px * look.supersampling,
                                              size.height_px * look.supersampling) *
                               clip_from_camera(camera, size.aspect()) * from_world;
  const Eigen::Matrix3d world_from_camera = from_world.topLeftCorner<3, 3>().transpose();
  program.set("clip_from_world", clip);
  program.set("point_size_px", look.point_size_px * look.supersampling);
  program.set("eye_m", camera.eye_m);
  program.set("view_direction", Eigen::Vector3d(-world_from_camera.col(2)));
  program.set("perspective", camera.projection == Projection::perspective ? 1.0 : 0.0);
  program.set("lamp_m", look.lamp_m);
  program.set("lamp_direction", Eigen::Vector3d(world_from_camera * lamp_in_camera()));
  const auto range = height_range_m(look, box_);
  program.set("low_m", range[0]);
  program.set("high_m", range[1]);
  return program;
}

const GlProgram& SurfacePass::surface_program(Coloring coloring, Light light, BackFaces backs) {
  std::unique_ptr<GlProgram>& program = programs_[{coloring, light, backs == BackFaces::faint}];
  if (!program) {
    const std::string defines = constants() + define_of(coloring) + define_of(light) +
                                (backs == BackFaces::faint ? "#define FAINT_BACKS\n" : "");
    program = std::make_unique<GlProgram>(gl_, defines, shaders::kSurfaceVertex,
                                          shaders::kSurfaceFragment);
  }
  return *program;
}

}  // namespace marco::viewer
