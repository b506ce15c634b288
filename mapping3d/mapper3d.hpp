#pragma once

#include <map>
#include <vector>

#include "common/trajectory.hpp"
#include "mapping3d/registration.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/scene_mesh.hpp"
#include "mapping3d/straightening.hpp"

namespace marco::mapping3d {

struct Mapper3dOptions {
  SceneBuilderOptions builder;
  RobotBox robot;
  SceneMeshOptions mesh;
  bool refine = true;  ///< join scenes in 3D; otherwise they stay where the robot's path puts them
  double min_gain =
      0.75;               ///< unless it brings patches so much nearer (median), the path is trusted
  double stop_m = 0.05;   ///< sweeps from places nearer to each other than this ...
  double stop_deg = 1.0;  ///< ... and than this are of one stop, and are moved as one
  RegistrationOptions registration;
  bool straighten = true;  ///< rows that were not at the angles they say are turned where they were
  StraighteningOptions straightening;

  template <class Visitor>
  void visit(Visitor& v) {
    v("builder", builder);
    v("robot", robot);
    v("mesh", mesh);
    v("refine", refine);
    v("min_gain", min_gain, Limits{0.0, 1.0});
    v("stop_m", stop_m, kNotNegative);
    v("stop_deg", stop_deg, kNotNegative);
    v("registration", registration);
    v("straighten", straighten);
    v("straightening", straightening);
  }
};

/// The pipeline: rows become scenes, placed by the robot's poses, moved with them when a loop
/// closes, and joined in 3D. Not thread-safe.
class Mapper3d {
 public:
  explicit Mapper3d(const Mapper3dOptions& options = {});

  /// @returns whether a scene was finished by this row.
  bool add(const SceneRow& row, double pan_rad, double tilt_rad);
  /// Ends the sweep under way. @returns whether it became a scene.
  bool finish();

  /// The robot's path changed: each row moves with the keyframe before it.
  /// @param keys   where the keyframes lie today
  /// @param known  where all scans lay until now, as the rows added so far know them
  void follow(const Trajectory& keys, const std::map<Utime, Pose2>& known);

  /// Joins all scenes in 3D, from where the path puts them; as a whole they stay there. What the
  /// robot swept standing still moves as one: one short sweep alone tells too little. Where joining
  /// brings them hardly nearer to each other, what it found is noise and they stay one by one.
  /// Sweeps whose rows then turn out to be bent are straightened, all together. Does nothing when
  /// nothing changed since the last time. Seconds for a hundred scenes.
  void refine();

  /// Rows by the robot's path of today, not refined.
  const std::vector<Scene>& scenes() const { return scenes_; }
  /// Each scene's points, world frame, as refined last.
  std::vector<ScenePoints> placed() const;
  /// All scenes' meshes in one, world frame, as refined last.
  TriangleMesh model() const;

  /// Of the last refine(), and whether scenes were moved by it.
  const RegistrationResult& registration() const { return registration_; }
  bool refined() const { return refined_; }
  const Straightening& straightening() const { return straightening_; }
  int64_t rows_without_scene() const { return builder_.rows_without_scene(); }

 private:
  bool keep(std::optional<Scene> scene);
  ScenePoints placed(std::size_t scene) const;
  std::vector<std::size_t> stop_of_each() const;
  void straighten_sweeps(const std::vector<std::size_t>& stops);

  Mapper3dOptions options_;
  SceneBuilder builder_;
  std::vector<Scene> scenes_;
  RegistrationResult registration_;
  Straightening straightening_;
  bool changed_ = false;  ///< since the last refine()
  bool refined_ = false;
};

}  // namespace marco::mapping3d
