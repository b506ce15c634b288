#pragma once

#include "lcm_tools/base/options.hpp"
#include "viewer/map_border.hpp"
#include "viewer/picture.hpp"
#include "viewer/scene.hpp"

namespace marco::viewer {

struct MapPictureOptions {
  double long_side_px = 1500.0;  ///< of the drawn map without its margins
  double margin_m = 0.5;         ///< of world around what is known
  double path_width_px = 2.5;    ///< of trajectories
  double point_radius_px = 0.9;  ///< of scan points
  double text_height_px = 13.0;  ///< of a capital

  template <class Visitor>
  void visit(Visitor& v) {
    v("long_side_px", long_side_px, Limits{100.0, 20000.0});
    v("margin_m", margin_m, kNotNegative);
    v("path_width_px", path_width_px, Limits{0.5, 50.0});
    v("point_radius_px", point_radius_px, Limits{0.25, 50.0});
    v("text_height_px", text_height_px, Limits{6.0, 100.0});
  }
};

struct MapPicture {
  Picture picture;
  MapFrame frame;
};

/// The 2D map as seen from above: the grid in grey (free white, unknown grey, walls black; the
/// likelier a wall the darker, with the unknown in the middle), points, walls, rays, ellipses,
/// paths and robots of the scene; meshes are left out. Beside it axes in metres, a scale bar and a
/// legend. The size follows from the well seen part of the map (find_extent); the legend says how
/// many cells lie beyond it.
/// @throws std::invalid_argument when there is nothing to draw, or an option is out of its limits.
MapPicture draw_map(const Scene& scene, const MapPictureOptions& options = {});

}  // namespace marco::viewer
