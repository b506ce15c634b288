#pragma once

#include <map>
#include <vector>

#include "common/trajectory.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/scene_mesh.hpp"

namespace marco::mapping3d {

struct Mapper3dOptions {
  SceneBuilderOptions builder;
  SceneMeshOptions mesh;

  template <class Visitor>
  void visit(Visitor& v) {
    v("builder", builder);
    v("mesh", mesh);
  }
};

/// The pipeline: rows become scenes, scenes become meshes, placed by the robot's poses and moved
/// with them when a loop closes. Not thread-safe.
class Mapper3d {
 public:
  explicit Mapper3d(const Mapper3dOptions& options = {});

  /// @returns whether a scene was finished by this row.
  bool add(const SceneRow& row, double pan_rad, double tilt_rad);
  /// Ends the sweep under way. @returns whether it became a scene.
  bool finish();

  /// The poses by which rows were placed until now, and where the same key scans lie today: each
  /// scene moves with the key scan before it.
  /// @param first_published  pose of each scan as it was when its rows were added
  void follow(const Trajectory& keys, const std::map<Utime, Pose2>& first_published);

  const std::vector<Scene>& scenes() const { return scenes_; }
  int64_t rows_without_scene() const { return builder_.rows_without_scene(); }

  /// All scenes' meshes in one, world frame.
  TriangleMesh model() const;

 private:
  bool keep(std::optional<Scene> scene);

  struct Placed {
    Pose2 correction;  ///< world today from world when the rows were added
  };
  Mapper3dOptions options_;
  SceneBuilder builder_;
  std::vector<Scene> scenes_;
  std::vector<Placed> placed_;
};

}  // namespace marco::mapping3d
