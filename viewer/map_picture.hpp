#pragma once

#include "lcm_tools/base/options.hpp"
#include "viewer/map_border.hpp"
#include "viewer/picture.hpp"
#include "viewer/scene.hpp"

namespace marco::viewer {

struct MapPictureOptions {
  double long_side_px = 1500.0;  ///< of the drawn map without its margins
  double margin_m = 0.5;         ///< around the known cells
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

/// The 2D map from above: the grid (white = free, grey = unknown, black = occupied), with the
/// points, walls, rays, ellipses, paths and robots of the scene, but without meshes. Axes in
/// metres, a scale bar and a legend are added. The picture shows the well seen part of the map
/// (find_extent); the legend counts the known cells beyond it.
/// @throws std::invalid_argument when there is nothing to draw, or an option is out of its limits.
MapPicture draw_map(const Scene& scene, const MapPictureOptions& options = {});

}  // namespace marco::viewer
