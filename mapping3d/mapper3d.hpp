#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/input/own_body.hpp"
#include "mapping3d/path_correction.hpp"
#include "mapping3d/registration.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/scene_mesh.hpp"
#include "mapping3d/straightening.hpp"
#include "mapping3d/surface/surface_model.hpp"

namespace marco::mapping3d {

struct Mapper3dOptions {
  SceneBuilderOptions builder;
  RobotBox robot;
  SceneMeshOptions mesh;
  bool refine = true;     ///< register scenes in 3D; otherwise they stay where the path puts them
  double stop_m = 0.05;   ///< sweeps taken within this distance ...
  double stop_deg = 1.0;  ///< ... and this turn belong to one stop and move as one body
  RegistrationOptions registration;
  bool straighten = true;  ///< correct the angles of rows that the pan-tilt reported wrongly
  StraighteningOptions straightening;
  /// Of the model. Configurations visit it under a separate name, so not in visit().
  SurfaceOptions surface;

  template <class Visitor>
  void visit(Visitor& v) {
    v("builder", builder);
    v("robot", robot);
    v("mesh", mesh);
    v("refine", refine, "Align the stops in 3D. Off to keep the poses of the 2D path.");
    v.advanced("stop_m", stop_m, kNotNegative,
               "Sweeps taken within this distance belong to one stop and move together.");
    v("registration", registration);
    v.advanced("straighten", straighten,
               "Correct the angles of the pan-tilt from the scans. Off for exact angles.");
  }
};

/// The 3D mapping pipeline: rows become scenes, scenes follow the robot's path when a loop closes,
/// registration (ICP) aligns them, and their fusion is the model. Not thread-safe.
class Mapper3d {
 public:
  explicit Mapper3d(const Mapper3dOptions& options = {});

  /// @param laser  whose row it is: each makes scenes of its own
  /// @returns whether this row completed a scene.
  bool add(const SceneRow& row, double pan_rad, double tilt_rad, const std::string& laser = {});
  /// Ends the current sweeps. @returns how many of them became scenes.
  std::size_t finish();

  /// Applies a new path: each row moves with the last keyframe before it, and the rows of one stop
  /// with its last one.
  void follow(const PathCorrection& correction);

  /// Leaves out what lasers see of the robot itself (find_own_body) and registers all scenes,
  /// starting from the path, which holds what surfaces do not constrain.
  /// Sweeps of one stop move as one body, since a single short sweep has too little overlap. Rows
  /// with wrong angles are straightened afterwards. Does nothing when nothing changed since the
  /// last call. Takes seconds for a hundred scenes.
  void refine();

  /// Rows on today's path, not refined; those of one stop lie where the last of them does.
  const std::vector<Scene>& scenes() const { return scenes_; }
  /// Each scene's points, world frame, as of the last refine().
  std::vector<ScenePoints> placed() const;
  /// The fused surface of all scenes, world frame, as of the last refine(). Computed on the first
  /// call after a change, about 0.1 s a scene; empty without scenes.
  const TriangleMesh& model() const;
  /// Each scene meshed by itself, all in one mesh (thesis B's model), world frame.
  TriangleMesh scene_meshes() const;
  /// Computes the model() and frees the rows' ranges, most of what a long log takes: the rows keep
  /// their poses. Afterwards add(), finish(), follow(), placed() and scene_meshes() throw
  /// std::logic_error.
  void finish_model();

  /// Of the last refine(), and whether it moved any scene.
  const RegistrationResult& registration() const { return registration_; }
  bool refined() const { return refined_; }
  const Straightening& straightening() const { return straightening_; }
  /// What the lasers see of the robot, as of the last refine(); no scene has its returns.
  const std::vector<BodyPart>& own_body() const { return own_body_; }
  int64_t rows_without_scene() const;

 private:
  bool keep(std::optional<Scene> scene, const std::string& laser);
  void leave_out_own_body();
  std::size_t first_scene_of_last_stop() const;
  /// SLAM knows a stop's place best at its end: puts all its rows there, from this scene on.
  void settle(std::size_t first_scene);
  ScenePoints placed(std::size_t scene) const;
  std::vector<std::size_t> stop_of_each() const;
  void straighten_sweeps(const std::vector<std::size_t>& stops);
  void set_changed();
  void require_ranges() const;  ///< @throws std::logic_error after finish_model()

  Mapper3dOptions options_;
  std::map<std::string, SceneBuilder> builders_;  ///< by laser
  std::vector<Scene> scenes_;
  std::vector<BodyPart> own_body_;
  RegistrationResult registration_;
  Straightening straightening_;
  bool changed_ = false;  ///< since the last refine()
  bool refined_ = false;
  bool finished_ = false;
  mutable std::optional<TriangleMesh> model_;  ///< of the scenes as they are placed now
};

}  // namespace marco::mapping3d
