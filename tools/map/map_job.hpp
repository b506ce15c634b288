#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/trajectory.hpp"
#include "common/trajectory_fit.hpp"
#include "lcm_tools/process/batch_bus.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"
#include "recordings/foreign.hpp"
#include "recordings/ros/split_recordings.hpp"
#include "recordings/sample_reader.hpp"
#include "slam/doctor/doctor.hpp"
#include "slam/process/line_slam_adapter.hpp"
#include "slam/process/slam_adapter.hpp"
#include "tools/map/joined_surface.hpp"
#include "tools/map/photographs.hpp"
#include "tools/map/stage_clock.hpp"

namespace marco {

struct MapOptions {
  /// A recording ends: its keyframes are kept for the joint refinement at the end, but four of a
  /// place are enough of a long one (ten rounds of the office cost 57 s in place of 97, and hold a
  /// third; the path is as good).
  MapOptions() {
    slam.slam.culling.after_keyframes = 2000;
    slam.slam.culling.keyframes_per_place = 4;
  }

  slam::SlamAdapterOptions slam;  ///< its input, keyframes and grid hold for the others, too
  slam::LineProcessOptions lines;
  mapping3d::Mapping3dAdapterOptions mapping3d;
  mapping3d::SurfacePipelineOptions joined_surface;
  PhotographOptions photographs;
  std::string odometry_fault;  ///< why no odometry is used, no setting; "" = it is used

  template <class Visitor>
  void visit(Visitor& v) {
    v("input", slam.input);
    v("slam", slam.slam);
    v("localizer", slam.localizer);
    v("lines", lines.mapper);
    v("model", mapping3d.mapper);
    v("surface", joined_surface);
    v("photographs", photographs);
  }
};

/// Who makes the path: the scan SLAM, or thesis A's line SLAM (`--lines`).
enum class PathMaker { scans, lines };

/// The main job on somebody's recordings, as fast as the machine can: reads them, feeds the same
/// adapters that run live through a BatchBus, and keeps what the pictures and the report need. A
/// pure function of its inputs, times excepted.
class MapJob {
 public:
  using Logged = process::BatchBus::Recorded;

  /// @param folder  where slam.lcm is written; must exist. @param logged  what it holds
  MapJob(const MapOptions& options,
         PathMaker maker,
         const std::filesystem::path& folder,
         Logged logged = Logged::all);

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
  void read(const RecordingParts& parts, const ForeignTable& foreign);
  /// @param name  of the recording, as shown meanwhile and in errors
  void read(files::SampleReader& recording, const std::filesystem::path& name);

  /// Optimizes for the last time, and completes slam.lcm.
  void finish();

  /// A pose a scan, in order of input, after the last optimization. Localizing: of the scans whose
  /// place was found.
  Trajectory trajectory() const;
  /// The same, one a scan: nothing of scans that are in no map, or in another one.
  std::vector<std::optional<Pose2>> poses() const { return mapper().scan_poses(); }
  /// The same, each pose as it was first published.
  const Trajectory& live_trajectory() const { return mapper2d_->live_trajectory(); }
  /// Raw odometry at the scans, where there was any.
  const Trajectory& odometry_trajectory() const { return mapper2d_->odometry_trajectory(); }
  /// One a scan.
  const std::vector<slam::UsedScan>& scans() const { return mapper2d_->scans(); }
  GridMap grid() const { return mapper().grid().to_map(); }
  /// What the scan SLAM's map is made of; empty where the line SLAM made the path.
  const std::vector<slam::Keyframe>& keyframes() const;
  /// Of the mapper that made the path.
  const std::vector<slam::Keyframe>& map_keys() const { return mapper().keys(); }
  /// The newest SENSOR_INFO of each channel, the laser's place corrected.
  const std::map<std::string, SensorInfo>& sensors() const { return recorded_.sensors; }
  std::size_t key_count() const { return mapper().keys().size(); }
  const std::vector<slam::Loop>& loops() const { return mapper().loops(); }
  const process::DropCounter& drops() const { return mapper2d_->drops(); }
  const ScanRules& scan_rules() const { return mapper2d_->input().rules(); }
  /// See MappingSession::mended; nothing of a line SLAM.
  slam::MapEdits mended() const {
    return session() != nullptr ? session()->mended() : slam::MapEdits{};
  }
  /// Nothing where the line SLAM makes the path.
  const slam::MappingSession* session() const {
    return slam_ != nullptr ? &slam_->session() : nullptr;
  }
  /// Nothing unless the line SLAM made the path.
  slam::LineSlamAdapter* lines() { return lines_; }
  const slam::LineSlamAdapter* lines() const { return lines_; }
  const mapping3d::Mapping3dAdapter& mapping3d() const { return mapping3d_; }
  /// See Mapper3d::finish_model. To be called after finish() and all uses of single sweeps.
  void finish_model() { mapping3d_.finish_model(); }
  const std::vector<files::InputReport>& inputs() const { return recorded_.inputs; }
  /// Where its laser is taken to sit, if not as SENSOR_INFO says.
  const LaserCalibration& laser() const { return laser_; }
  /// What its lasers' beams are taken to be.
  const std::vector<BeamCalibration>& beams() const { return beams_; }
  /// What the lasers see of their own robot: left out of all scans.
  const std::vector<BodyPart>& own_body() const { return own_body_; }
  const std::vector<FloorLine>& floor() const { return floor_; }
  /// The least bearing of a laser's beams as its first scan said it.
  double least_bearing_rad(const std::string& channel) const {
    const auto found = recorded_.least_bearing_rad.find(channel);
    return found == recorded_.least_bearing_rad.end() ? 0.0 : found->second;
  }
  const RecordedTruth& truth() const { return recorded_.truth; }
  /// Odometry as recorded, all of it; and the gyroscope's rate, integrated, as poses that only
  /// turn.
  const Trajectory& odometry() const { return recorded_.odometry; }
  const Trajectory& gyro_heading() const { return recorded_.gyro_heading; }
  StageClock& clock() { return clock_; }
  const StageClock& clock() const { return clock_; }
  /// Last stamp minus first, of the scans.
  double recorded_s() const;
  /// What the map's doctor judges; nothing when localizing, for then no map is made.
  std::optional<slam::MapEvidence> evidence() const;

 private:
  const slam::Mapper2d& mapper() const { return mapper2d_->mapper2d(); }
  void take(const Sample& sample);
  void note_bearings(const LaserScan& scan);
  void integrate(const ImuSample& sample);
  /// The line SLAM cannot look for itself. @throws std::invalid_argument where the keyframes from
  /// `first_key` on are not where they are believed to be in the map of those before.
  void check_that_lines_go_on(std::size_t first_key, const std::filesystem::path& input) const;

  /// What the recordings held besides scans.
  struct Recorded {
    std::vector<files::InputReport> inputs;
    std::map<std::string, SensorInfo> sensors;
    std::map<std::string, double> least_bearing_rad;  ///< of each laser's first scan
    RecordedTruth truth;
    Trajectory odometry;
    Trajectory gyro_heading;
  };

  files::OutputFile log_file_;
  files::EventLogWriter log_;
  process::BatchBus bus_;
  std::unique_ptr<slam::Mapper2dAdapter> mapper2d_;
  slam::SlamAdapter* slam_;       ///< mapper2d_, or nullptr
  slam::LineSlamAdapter* lines_;  ///< likewise
  mapping3d::Mapping3dAdapter mapping3d_;
  slam::SlamOptions slam_options_;
  slam::LocalizerOptions localizer_options_;
  LaserCalibration laser_;
  std::vector<BeamCalibration> beams_;
  std::vector<BodyPart> own_body_;
  std::vector<FloorLine> floor_;
  Recorded recorded_;
  std::string odometry_fault_;  ///< see MapOptions
  slam::MapEdits edits_;
  /// Of each recording: the scans, and the odometry at them, that came before.
  struct FirstOf {
    std::size_t scan;
    std::size_t odometry;
  };
  std::vector<FirstOf> recordings_;
  StageClock clock_;
};

}  // namespace marco
