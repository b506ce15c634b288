#pragma once

#include <functional>
#include <string>
#include <vector>

#include "viewer/scene.hpp"

namespace marco::viewer {

/// How files become values; each throws an exception naming the path when it cannot.
struct FileReaders {
  std::function<TriangleMesh(const std::string& path)> mesh;      ///< .ply, .glb
  std::function<GridMap(const std::string& path)> grid;           ///< .yaml of the map_server kind
  std::function<Trajectory(const std::string& path)> trajectory;  ///< .tum
};

/// A place to walk through a model, e.g. a window; each may be empty where there is none.
struct WalkDesk {
  /// Opens it. @returns false where there is no display.
  std::function<bool()> open;
  std::function<void(const Picture&)> show;
  std::function<char()> next_key;  ///< waits; 0 when it was closed
};

/// What was found, and what of it could not be used.
struct Inputs {
  Scene scene;
  std::vector<std::string> skipped;  ///< "path: why", for a person
};

/// Reads models, maps, trajectories, and folders written by `map`: of a folder, model.ply,
/// map.yaml, trajectory.tum (estimate), odometry.tum and truth.tum where they are there, these two
/// laid on the estimate: odometry by its first pose, truth by the best fit.
/// @throws std::invalid_argument naming the path and what was expected when nothing of an input
/// could be used; what is broken beside something good is skipped and told.
Inputs read_inputs(const std::vector<std::string>& paths, const FileReaders& readers);

}  // namespace marco::viewer
