#pragma once

#include <functional>
#include <string>
#include <vector>

#include "viewer/scene.hpp"

namespace marco::viewer {

/// Readers of files; each throws an exception naming the path when it fails.
struct FileReaders {
  std::function<TriangleMesh(const std::string& path)> mesh;      ///< .ply, .obj, .glb
  std::function<GridMap(const std::string& path)> grid;           ///< .yaml of the map_server kind
  std::function<Trajectory(const std::string& path)> trajectory;  ///< .tum
};

/// The scene, and the files that could not be used.
struct Inputs {
  Scene scene;
  std::vector<std::string> skipped;  ///< "path: why"
};

/// Of a folder that holds both: model.ply, or model.glb, which is simplified. A vector page of the
/// full one takes tens of megabytes.
enum class FolderModel { full, simplified };

/// Reads models, maps, trajectories, and folders written by `map`: of a folder, its model,
/// map.yaml, trajectory.tum (estimate), odometry.tum and truth.tum where they exist; the last two
/// are aligned with the estimate: odometry by its first pose, truth by the best fit.
/// @throws std::invalid_argument naming the path and what was expected when nothing of an input can
/// be used. A broken file next to a good one is skipped and reported.
Inputs read_inputs(const std::vector<std::string>& paths,
                   const FileReaders& readers,
                   FolderModel model = FolderModel::full);

}  // namespace marco::viewer
