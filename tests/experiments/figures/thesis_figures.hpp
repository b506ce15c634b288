#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mapping3d/scene.hpp"
#include "mapping3d/thesis_mesh.hpp"
#include "viewer/renderer.hpp"

namespace marco {

/// Thesis B's figures 5.13-5.17 and 5.19-5.21 from other sweeps; 5.16 is closer to an edge near the
/// laser, 5.17 of four_ways().
struct FigureOptions {
  viewer::PictureSize size{1000, 750};
  viewer::Mode mode = viewer::Mode::filled;
  int cut_ends = 0;  ///< beams left off each end of every row (thesis B, app. C)
  mapping3d::ThesisMeshOptions rule;
};

struct Figure {
  std::string file;  ///< in the folder
  std::string what;  ///< with its counts, for a person
};

/// A sweep without the outer `count` beams of each row.
mapping3d::ScenePoints without_ends(mapping3d::ScenePoints scene, int count);

/// Each triangle with vertices and a normal of its own, as the thesis draws them.
TriangleMesh flat_triangles(const mapping3d::ScenePoints& scene,
                            const mapping3d::ThesisMeshOptions& rule = {});
/// Each quad as two triangles with a normal a corner, by the corner's own two edges.
TriangleMesh quads_as_triangles(const mapping3d::ScenePoints& scene,
                                const mapping3d::ThesisMeshOptions& rule = {});

/// Writes the figures as PNG, and all in one as figures.png. @param stops sweeps by the robot's
/// places, in order; 5.20 and 5.21 need two places. @throws std::invalid_argument of no sweep.
std::vector<Figure> draw_thesis_figures(
    const std::filesystem::path& folder,
    const std::vector<std::vector<mapping3d::ScenePoints>>& stops,
    const FigureOptions& options = {});

/// Where most of a sweep's beams went, level; unit length.
Eigen::Vector3d ahead_of(const mapping3d::ScenePoints& sweep);

/// Up to four sweeps of full tilt that look to different sides, the first ones.
/// @param stop  at least one sweep
std::vector<mapping3d::ScenePoints> four_ways(const std::vector<mapping3d::ScenePoints>& stop);

/// By where the robot stood: a new stop where it had gone farther than `apart_m`.
std::vector<std::vector<mapping3d::ScenePoints>> by_stop(
    const std::vector<mapping3d::Scene>& scenes, double apart_m = 0.3);

}  // namespace marco
