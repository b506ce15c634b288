#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/pose3.hpp"
#include "lcm_tools/base/options.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::mapping3d {

/// One scan of a sweep with the motion of the laser during it.
struct SceneRow {
  Utime utime;                  ///< of the first beam
  std::vector<float> ranges_m;  ///< 0 = no return
  /// Empty, or when each column was measured: 0 = at the first beam's time, 1 = at the last one's.
  std::vector<float> beam_parts;
  double first_bearing_rad = 0.0;  ///< of column 0, counter-clockwise from ahead
  double bearing_step_rad = 0.0;
  Pose3 robot_from_sensor_first = Pose3::Identity();  ///< at the first beam
  Pose3 robot_from_sensor_last = Pose3::Identity();   ///< at the last beam; the pan-tilt may move
  Pose2 world_from_robot;                             ///< at the first beam
  Pose2 first_robot_from_last_robot;                  ///< the robot's motion until the last beam
  double duration_s = 0.0;                            ///< from the first beam to the last
  std::optional<Utime> stop;   ///< rows of one stop have the same: the robot stood meanwhile
  double pan_first_rad = 0.0;  ///< the angles behind the sensor poses, for the calibration
  double pan_last_rad = 0.0;
  double tilt_first_rad = 0.0;
  double tilt_last_rad = 0.0;
};

/// The organized ranges of one sweep: rows of neighbouring tilt (or pan), columns of neighbouring
/// bearing.
struct Scene {
  int number = 0;
  std::vector<SceneRow> rows;
  std::string laser = {};  ///< whose rows they are

  std::size_t columns() const { return rows.empty() ? 0 : rows.front().ranges_m.size(); }
};

/// A scene's points in the world, row by row; beams without a return are not `valid`.
struct ScenePoints {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<Eigen::Vector3f> points_m;
  std::vector<Eigen::Vector3f> origins_m;  ///< one a row: where its middle beam came from
  std::vector<uint8_t> valid;

  std::size_t index(std::size_t row, std::size_t column) const { return row * columns + column; }
};

/// Scenes that are placed when they are asked for: the beams of a hundred stops do not fit into
/// memory at once.
struct PlacedScenes {
  std::size_t count = 0;
  std::function<ScenePoints(std::size_t)> at;

  /// @param all  outlives it
  static PlacedScenes of(const std::vector<ScenePoints>& all) {
    return {all.size(), [&all](std::size_t scene) { return all[scene]; }};
  }
};

/// A box about the robot's origin on the floor. Returns from inside it come from the robot itself
/// and are dropped. Off while the height is zero.
struct RobotBox {
  double ahead_m = 0.0;
  double behind_m = 0.0;
  double half_width_m = 0.0;
  double height_m = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("ahead_m", ahead_m, kNotNegative,
      "Returns from the robot itself are removed: its length ahead of the robot frame's origin. 0 "
      "keeps all.");
    v("behind_m", behind_m, kNotNegative, "The robot's length behind the robot frame's origin.");
    v("half_width_m", half_width_m, kNotNegative, "Half of the robot's width.");
    v("height_m", height_m, kNotNegative, "The robot's height.");
  }
};

/// Deskews a sweep (row motion): places each beam by the pose interpolated between its row's first
/// and last beam (thesis B eq. 4.1, in our axes: common/samples.hpp), while pan-tilt and robot
/// move. Ranges that are not finite and positive are no returns; a row shorter than the first ends
/// early.
ScenePoints place(const Scene& scene, const RobotBox& robot = {});

/// Transforms the points.
void move(ScenePoints& scene, const Pose3& to_from_world);

struct SceneBuilderOptions {
  double min_step_deg = 0.05;  ///< a smaller step repeats the row
  double max_step_deg = 6.0;   ///< a larger step begins another sweep
  double pause_s = 1.5;        ///< a longer pause of the pan-tilt ends the sweep
  double max_drive_m = 0.5;    ///< a longer drive during a pause ends the sweep
  int min_rows = 10;           ///< of a scene

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("max_step_deg", max_step_deg, kPositive,
               "A larger step of the pan-tilt starts another sweep. More for a fast pan-tilt.");
    v.advanced("pause_s", pause_s, kPositive, "A longer pause of the pan-tilt ends the sweep.");
    v.advanced("max_drive_m", max_drive_m, kPositive,
               "A longer drive during a pause ends the sweep.");
    v.advanced("min_rows", min_rows, Limits{2, 100000}, "Sweeps of fewer rows are not used.");
  }
};

/// Finds the sweeps in one laser's stream of scans. A sweep lasts while tilt (or pan) moves in one
/// direction, in steps or continuously, whether the robot stands or drives; it ends when the
/// direction changes or the pan-tilt pauses or jumps, and after a full turn. Where neither moves
/// and the scan plane is steep, the robot sweeps it as it drives or turns (push-broom). A single
/// row of another width is skipped. A row in the scan plane of the last one repeats it, unless its
/// beams are shifted: a level laser that pans sweeps nothing. Not thread-safe.
class SceneBuilder {
 public:
  explicit SceneBuilder(const SceneBuilderOptions& options = {});

  /// @param pan_rad, tilt_rad  at the row's middle beam.
  /// @returns the sweep that this row has ended.
  std::optional<Scene> add(SceneRow row, double pan_rad, double tilt_rad);

  /// Ends the current sweep.
  std::optional<Scene> finish();

  /// Rows of sweeps shorter than min_rows.
  int64_t rows_without_scene() const { return rows_without_scene_; }

  /// The rows of the current sweep, to be moved when the robot's path changes.
  std::vector<SceneRow>& rows() { return rows_; }

 private:
  enum class Axis { none, pan, tilt, drive, turn };
  struct Step {
    Axis axis = Axis::none;
    int sign = 0;
    bool jump = false;
    double turned_deg = 0.0;  ///< about the pan-tilt's axis or the robot's
    double drove_m = 0.0;     ///< across the scan plane
  };
  Step step_to(const SceneRow& row, double pan_rad, double tilt_rad) const;
  Step step_by_robot(const SceneRow& row) const;
  /// Whether `step` goes another way than the sweep did.
  bool turns_back(const Step& step) const;
  bool is_whole() const;
  /// Whether it looks between the beams of the rows taken at this angle, as interlaced modes do.
  bool is_shifted(const SceneRow& row) const;
  void start(SceneRow row, double pan_rad, double tilt_rad);

  SceneBuilderOptions options_;
  std::vector<SceneRow> rows_;
  double pan_rad_ = 0.0;  ///< of the last row
  double tilt_rad_ = 0.0;
  Step direction_;             ///< of the last step; its amounts are the whole sweep's
  bool last_was_odd_ = false;  ///< the last row had another width and was skipped
  int scenes_ = 0;
  int64_t rows_without_scene_ = 0;
};

}  // namespace marco::mapping3d
