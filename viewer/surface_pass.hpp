#pragma once

#include <map>
#include <memory>
#include <tuple>

#include "viewer/detail_levels.hpp"
#include "viewer/gl_functions.hpp"
#include "viewer/gl_program.hpp"
#include "viewer/renderer.hpp"
#include "viewer/scene_geometry.hpp"

namespace marco::viewer {

/// Vertices and indices held by the driver. Lives no longer than the context its functions belong
/// to.
class GpuGeometry {
 public:
  GpuGeometry(const GlFunctions& gl, const Geometry& geometry);
  ~GpuGeometry();
  GpuGeometry(const GpuGeometry&) = delete;
  GpuGeometry& operator=(const GpuGeometry&) = delete;

  /// @param primitive GL_TRIANGLES, GL_LINES or GL_POINTS, as the indices were meant.
  void draw(GLenum primitive) const;
  /// Other indices of the same vertices from now on.
  void set_indices(const std::vector<uint32_t>& indices);
  /// Every vertex as a point, whatever the indices join.
  void draw_vertices() const;
  GLsizei index_count() const { return index_count_; }

 private:
  const GlFunctions& gl_;
  GLuint array_ = 0;
  GLuint vertices_ = 0;
  GLuint indices_ = 0;
  GLsizei vertex_count_;
  GLsizei index_count_;
};

/// A part of the whole picture, in its supersampled pixels, y from the bottom as OpenGL counts.
struct Tile {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// Stretches the tile's part of clip space over the whole of it. @param width, height of the whole
Eigen::Matrix4d tile_from_clip(const Tile& tile, int width, int height);

/// A scene held by the driver, and drawn: surfaces, points, lines, without their shadows. Lives no
/// longer than the context its functions belong to.
class SurfacePass {
 public:
  explicit SurfacePass(const GlFunctions& gl) : gl_(gl) {}

  /// Replaces the scene that was loaded before.
  void load(const Scene& scene);
  /// Into the bound target, which is cleared.
  void draw(const Camera& camera, const Look& look, PictureSize size, const Tile& tile);
  /// The meshes once more by a bare glDrawElements, as the last draw() left the driver.
  void draw_bare() const { surfaces_->draw(GL_TRIANGLES); }

  /// Of the meshes.
  std::size_t triangle_count() const;
  const Box& box() const { return box_; }

 private:
  void draw_meshes(const Camera& camera, const Look& look, PictureSize size, const Tile& tile);
  void draw_levels(const Camera& camera, const Look& look, PictureSize size, const Tile& tile);
  const GlProgram& prepare(const GlProgram& program,
                           const Camera& camera,
                           const Look& look,
                           PictureSize size,
                           const Tile& tile);
  const GlProgram& surface_program(Coloring coloring, Light light, BackFaces backs);

  const GlFunctions& gl_;
  std::map<std::tuple<Coloring, Light, bool>, std::unique_ptr<GlProgram>> programs_;
  std::unique_ptr<GpuGeometry> surfaces_, props_, points_, lines_;
  Geometry source_;  ///< of surfaces_, for its levels
  std::unique_ptr<DetailLevels> levels_;
  std::vector<uint32_t> level_indices_, chosen_;
  std::unique_ptr<GpuGeometry> levelled_;
  Box box_;
};

}  // namespace marco::viewer
