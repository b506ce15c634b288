#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/grid_map.hpp"
#include "common/input/sensor_calibration.hpp"
#include "common/trajectory.hpp"
#include "common/trajectory_fit.hpp"
#include "recordings/foreign.hpp"
#include "recordings/ros/split_recordings.hpp"
#include "recordings/sample_reader.hpp"
#include "slam/map/map_edit.hpp"
#include "slam/mapper2d.hpp"
#include "tools/map/stage_clock.hpp"

namespace marco {

/// What the recordings of a job contain besides scans.
struct Recorded {
  std::vector<files::InputReport> inputs;
  std::map<std::string, SensorInfo> sensors;  ///< the newest of each channel, corrected mounts
  RecordedTruth truth;
  Trajectory odometry;      ///< as recorded, all of it
  Trajectory gyro_heading;  ///< the gyroscope's rate, integrated: poses that only turn

  void add(const Sample& sample);
  /// The least bearing of a laser's beams in its first scan; 0 without one.
  double least_bearing_rad(const std::string& channel) const;

 private:
  void note_bearings(const LaserScan& scan);
  void integrate(const ImuSample& sample);

  std::map<std::string, double> least_bearing_rad_;
};

namespace mapping3d {
class Mapping3dAdapter;
}
namespace slam {
struct MapEvidence;
class LineMapper;
class Mapper2dAdapter;
class MappingSession;
}  // namespace slam

struct MapOptions;

/// Who makes the path: the scan SLAM, or thesis A's line SLAM (`--lines`).
enum class PathMaker { scans, lines };

/// What slam.lcm holds: the recordings' messages and what was published, or the latter alone.
enum class Logged { all, published };

/// The main job on somebody's recordings, as fast as the machine can: reads them, feeds the same
/// adapters that run live through a BatchBus, and keeps what the pictures and the report need. A
/// pure function of its inputs, times excepted.
class MapJob {
 public:
  /// @param folder  where slam.lcm is written; must exist
  MapJob(const MapOptions& options,
         PathMaker maker,
         const std::filesystem::path& folder,
         Logged logged = Logged::all);
  /// By the scan SLAM, with the default options.
  explicit MapJob(const std::filesystem::path& folder);
  ~MapJob();

  /// Before reading: continues a saved map, or localizes in it (PathMaker::scans only).
  /// @throws std::invalid_argument naming the file and what is wrong with it.
  void extend(const std::filesystem::path& map_folder);
  /// @param map_from_robot  where the recording begins; without it the place is searched
  void localize(const std::filesystem::path& map_folder,
                const std::optional<Pose2>& map_from_robot);

  /// Before reading: scans, loops and odometry are used as these say (PathMaker::scans only).
  void set_edits(const slam::MapEdits& edits);

  /// Reads a recording to its end; several are sessions, see slam::MappingSession.
  /// @throws std::invalid_argument when it cannot be read at all, std::runtime_error when the disk
  /// is full.
  void read(const RecordingParts& parts, const ForeignTable& foreign = {});
  /// @param name  of the recording, as shown meanwhile and in errors
  void read(files::SampleReader& recording, const std::filesystem::path& name);

  /// Optimizes for the last time, and completes slam.lcm.
  void finish();

  /// A pose a scan, in order of input, after the last optimization. Localizing: of the scans whose
  /// place was found.
  Trajectory trajectory() const;
  GridMap grid() const { return mapper().grid().to_map(); }
  /// Of the map that was made, or localized in.
  const slam::Mapper2d& mapper() const;
  /// Scans and path as they came, and what was dropped.
  const slam::Mapper2dAdapter& adapter() const;
  /// What the scan SLAM's map is made of; empty where the line SLAM made the path.
  const std::vector<slam::Keyframe>& keyframes() const;
  /// Nothing where the line SLAM makes the path.
  const slam::MappingSession* session() const;
  /// Nothing unless the line SLAM made the path.
  const slam::LineMapper* lines() const;
  const mapping3d::Mapping3dAdapter& mapping3d() const;
  /// See Mapper3d::finish_model. To be called after finish() and all uses of single sweeps.
  void finish_model();
  /// What the recordings contain besides scans.
  const Recorded& recorded() const { return recorded_; }
  /// That the map was made with, and what sweeps showed of the robot's own body.
  const SensorCalibration& calibration() const { return calibration_; }
  /// Repairs by the scan SLAM, see MappingSession; nothing of a line SLAM.
  slam::MapEdits mended() const;
  /// What the map's doctor judges; nothing when localizing, for then no map is made.
  std::optional<slam::MapEvidence> evidence() const;
  /// Last stamp minus first, of the scans.
  double recorded_s() const;
  StageClock& clock() { return clock_; }
  const StageClock& clock() const { return clock_; }

 private:
  struct Run;
  /// Of each recording: the scans, and the odometry at them, that came before.
  struct FirstOf {
    std::size_t scan;
    std::size_t odometry;
  };
  void take(const Sample& sample);

  std::unique_ptr<Run> run_;
  SensorCalibration calibration_;
  Recorded recorded_;
  std::vector<FirstOf> recordings_;
  StageClock clock_;
};

}  // namespace marco
