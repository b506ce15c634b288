#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "viewer/camera.hpp"
#include "viewer/picture.hpp"
#include "viewer/scene.hpp"

namespace marco::viewer {

enum class Mode { points, wire, filled };
enum class Coloring { height, normal, scene, grey };
enum class Light { room, thesis };
/// How triangles look from behind. faint: a quarter of their colour over the background, when
/// supersampled by 2 or 4.
enum class BackFaces { show, faint, hide };

/// How a scene is drawn.
struct Look {
  Mode mode = Mode::filled;  ///< of meshes; all else is filled
  Coloring coloring = Coloring::height;
  Light light = Light::room;
  BackFaces back_faces = BackFaces::show;                         ///< of meshes
  double cut_height_m = std::numeric_limits<double>::infinity();  ///< meshes end here: no ceiling
  double point_size_px = 2.0;
  double occlusion_radius_m = 0.45;  ///< of the shadows in corners; 0 = none
  double detail_px = 0.0;  ///< largest error of simplified surfaces in the picture; 0 = draw every
                           ///< triangle
  int supersampling = 2;   ///< 1..4; a pixel is the average of its square samples
  Rgb background{247, 248, 250};
  Eigen::Vector3d lamp_m = Eigen::Vector3d(0.0, 0.0, 0.5);  ///< Light::thesis
  std::optional<std::array<double, 2>> height_range_m;      ///< of the colours; else the scene's
};

/// Thesis B's own look (ch. 4, app. C): 95 % grey, one lamp at the sensor's place, no shadow.
Look thesis_look(Mode mode = Mode::filled);

/// Lowest and highest of the height colours: the look's, else the box below the cut.
std::array<double, 2> height_range_m(const Look& look, const Box& box);

struct PictureSize {
  int width_px = 1280;
  int height_px = 720;
  double aspect() const { return static_cast<double>(width_px) / height_px; }
};

/// Draws one scene from many cameras. load() copies the scene to the driver once. To be used on the
/// thread that constructed it.
class Renderer {
 public:
  /// @throws std::runtime_error as make_gl_context().
  Renderer();
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Replaces the scene that was loaded before.
  void load(const Scene& scene);

  /// Pictures beyond the driver's limit are drawn in tiles.
  /// @throws std::invalid_argument on a size below 1 px or above 60 000 px, supersampling outside
  /// 1..4, or a camera that sees nothing (camera.hpp).
  Picture draw(const Camera& camera, const Look& look, PictureSize size);

  /// Distance along the line of sight of what draw() shows, row by row, top row first [m];
  /// infinity where there is nothing. @throws as draw, and beyond the driver's limit.
  std::vector<float> draw_depth_m(const Camera& camera, const Look& look, PictureSize size);

  /// The meshes' triangles now loaded, and the box of the whole scene.
  std::size_t triangle_count() const;
  const Box& box() const;

  /// For measurements: draws into memory of the driver and waits, without shadow or reading back.
  void draw_unread(const Camera& camera, const Look& look, PictureSize size);
  /// The same buffers, program and target as draw_unread's last call by a bare glDrawElements.
  void draw_bare();

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace marco::viewer
