#pragma once

#include "viewer/model_picture.hpp"

namespace marco::viewer {

/// Chooses the camera for a map with upright walls (Scene::grid_wall_height_m > 0).
/// above: from the south at a slant, so that north is up and east is right as in draw_map().
/// front: lower and from a corner. eye: see best_outlook().
/// @param scene has a grid and no meshes.
/// @throws std::invalid_argument when the map has no known cell.
ViewPlan plan_map_view(
    const Scene& scene, View view, const Look& look, Projection projection, PictureSize size);

/// Colours by height from floor to top of the walls; the undersides of the tops are hidden.
Look map_look(Look look, double wall_height_m);

/// The viewpoint on the path, and the heading, with the best view: far along free cells, with walls
/// on both sides. At least half a metre from walls where possible.
/// @param path in the map's frame; where it is empty or lies off the map, any free cell may be
/// chosen.
/// @returns the origin, looking along x, when the map has no free cell.
Pose2 best_outlook(const GridMap& grid, const Trajectory& path);

/// The box around the well seen part of the map (find_extent), walls included.
Box map_box(const GridMap& grid, double wall_height_m);

}  // namespace marco::viewer
