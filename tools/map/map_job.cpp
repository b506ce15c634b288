#include "tools/map/map_job.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lcm_tools/process/batch_bus.hpp"
#include "lcm_tools/process/progress.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/convert.hpp"
#include "recordings/recording.hpp"
#include "slam/doctor/doctor.hpp"
#include "slam/process/line_slam_adapter.hpp"
#include "slam/process/map_folder.hpp"
#include "slam/session/merge_maps.hpp"
#include "tools/map/map_options.hpp"

namespace marco {
namespace {

slam::LineProcessOptions lines_of(const MapOptions& options) {
  slam::LineProcessOptions lines = options.lines;
  lines.input = options.slam.input;
  lines.mapper.slam = options.slam.slam;
  return lines;
}

mapping3d::Mapping3dAdapterOptions mapping3d_of(const MapOptions& options) {
  mapping3d::Mapping3dAdapterOptions mapping3d = options.mapping3d;
  mapping3d.input = options.slam.input;
  mapping3d.mapper.surface = options.joined_surface.surface;
  return mapping3d;
}

// The line SLAM cannot relocalize. @throws std::invalid_argument where the keyframes from
// `first_key` on are not where they are believed to be in the map of those before.
void require_that_lines_go_on(const std::vector<slam::Keyframe>& keys,
                              std::size_t first_key,
                              const MapOptions& options,
                              const std::filesystem::path& input) {
  const auto middle = keys.begin() + static_cast<std::ptrdiff_t>(first_key);
  const std::vector<slam::Keyframe> session(middle, keys.end());
  slam::FrozenMap before({keys.begin(), middle}, options.slam.localizer, options.slam.slam);
  const auto found = slam::find_session(before, session, options.slam.localizer);
  const std::string cure = ": map them one by one, or all without --lines";
  require(found.has_value(),
          input.string() + ": was not found in the map of the previous recordings" + cure);
  constexpr double kNearM = 1.0, kNearDeg = 20.0;
  const Pose2& believed = session[static_cast<std::size_t>(found->newest_key)].world_from_robot;
  const Pose2 off = between(believed, found->place.map_from_robot);
  require(off.translation_m().norm() < kNearM && std::abs(off.theta_rad) < deg_to_rad(kNearDeg),
          input.string() +
              ": does not begin where the previous recording ends, and the line SLAM does not "
              "search elsewhere" +
              cure);
}

}  // namespace

void Recorded::add(const Sample& sample) {
  if (const auto* pose = std::get_if<TruePose>(&sample)) truth.add(*pose);
  if (const auto* imu = std::get_if<ImuSample>(&sample)) integrate(*imu);
  if (const auto* scan = std::get_if<LaserScan>(&sample)) note_bearings(*scan);
  if (const auto* info = std::get_if<SensorInfo>(&sample)) note_sensor(sensors, *info);
  if (const auto* sampled = std::get_if<OdometrySample>(&sample)) {
    odometry.push_back({sampled->utime, sampled->odom_from_robot});
  }
}

double Recorded::least_bearing_rad(const std::string& channel) const {
  const auto found = least_bearing_rad_.find(channel);
  return found == least_bearing_rad_.end() ? 0.0 : found->second;
}

void Recorded::note_bearings(const LaserScan& scan) {
  if (scan.size() == 0 || least_bearing_rad_.contains(scan.channel)) return;
  double least_rad = scan.bearing_rad(0);
  for (std::size_t i = 1; i < scan.size(); ++i) {
    least_rad = std::min(least_rad, scan.bearing_rad(i));
  }
  least_bearing_rad_[scan.channel] = least_rad;
}

void Recorded::integrate(const ImuSample& sample) {
  double heading_rad = 0.0;
  if (!gyro_heading.empty()) {
    const StampedPose2& last = gyro_heading.back();
    if (sample.utime <= last.utime) return;
    heading_rad = integrated_heading_rad(last, sample).value_or(last.world_from_robot.theta_rad);
  }
  gyro_heading.push_back({sample.utime, {0.0, 0.0, heading_rad}});
}

/// What turns samples into a map. The bus outlives what listens to it.
struct MapJob::Run {
  Run(const MapOptions& given,
      PathMaker maker,
      const std::filesystem::path& folder,
      process::BatchBus::Recorded logged)
      : options(given),
        log_file(folder / "slam.lcm", files::Appears::when_renamed),
        log(log_file),
        bus(&log, logged),
        scans(maker == PathMaker::scans ? std::make_unique<slam::SlamAdapter>(bus, given.slam)
                                        : nullptr),
        lines(maker == PathMaker::lines
                  ? std::make_unique<slam::LineSlamAdapter>(lines_of(given), bus)
                  : nullptr),
        adapter(scans != nullptr ? static_cast<slam::Mapper2dAdapter&>(*scans) : *lines),
        mapping3d(bus, mapping3d_of(given)) {}

  const MapOptions options;
  slam::MapEdits edits;
  files::OutputFile log_file;
  files::EventLogWriter log;
  process::BatchBus bus;
  const std::unique_ptr<slam::SlamAdapter> scans;  ///< one of both
  const std::unique_ptr<slam::LineSlamAdapter> lines;
  slam::Mapper2dAdapter& adapter;  ///< that one
  mapping3d::Mapping3dAdapter mapping3d;
};

MapJob::MapJob(const MapOptions& options,
               PathMaker maker,
               const std::filesystem::path& folder,
               Logged logged)
    : run_(std::make_unique<Run>(options,
                                 maker,
                                 folder,
                                 logged == Logged::all ? process::BatchBus::Recorded::all
                                                       : process::BatchBus::Recorded::published)),
      calibration_(options.slam.input.calibration) {
  run_->adapter.keep_scans();
}

MapJob::MapJob(const std::filesystem::path& folder)
    : MapJob(MapOptions{}, PathMaker::scans, folder) {}

MapJob::~MapJob() = default;

const slam::Mapper2d& MapJob::mapper() const { return run_->adapter.mapper2d(); }

const slam::Mapper2dAdapter& MapJob::adapter() const { return run_->adapter; }

const slam::MappingSession* MapJob::session() const {
  return run_->scans != nullptr ? &run_->scans->session() : nullptr;
}

const slam::LineMapper* MapJob::lines() const {
  return run_->lines != nullptr ? &std::as_const(*run_->lines).mapper() : nullptr;
}

const mapping3d::Mapping3dAdapter& MapJob::mapping3d() const { return run_->mapping3d; }

void MapJob::finish_model() { run_->mapping3d.finish_model(); }

slam::MapEdits MapJob::mended() const {
  return session() != nullptr ? session()->mended() : slam::MapEdits{};
}

Trajectory MapJob::trajectory() const {
  const std::vector<std::optional<Pose2>> known = mapper().scan_poses();
  Trajectory trajectory;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i]) trajectory.push_back({adapter().live_trajectory()[i].utime, *known[i]});
  }
  return trajectory;
}

const std::vector<slam::Keyframe>& MapJob::keyframes() const {
  static const std::vector<slam::Keyframe> kNone;
  return session() != nullptr ? session()->keys() : kNone;
}

void MapJob::extend(const std::filesystem::path& map_folder) {
  run_->scans->extend(slam::load_map_folder(map_folder));
  clock_.end_stage("load map");
}

void MapJob::localize(const std::filesystem::path& map_folder,
                      const std::optional<Pose2>& map_from_robot) {
  run_->scans->localize(slam::load_map_folder(map_folder));
  if (map_from_robot) run_->scans->set_pose(*map_from_robot);
  clock_.end_stage("load map");
}

void MapJob::set_edits(const slam::MapEdits& edits) {
  run_->edits = edits;
  run_->scans->set_edits(edits);
}

void MapJob::read(const RecordingParts& parts, const ForeignTable& foreign) {
  read(*open_recording(parts, foreign), parts.front());
}

void MapJob::read(files::SampleReader& recording, const std::filesystem::path& input) {
  if (!recorded_.inputs.empty()) run_->adapter.start_session();
  recordings_.push_back(
      {adapter().live_trajectory().size(), adapter().odometry_trajectory().size()});
  const std::size_t first_key = mapper().keys().size();
  process::Progress progress("mapping " + input.filename().string());
  while (std::optional<Sample> sample = recording.next()) {
    process::end_if_interrupted();
    // In slam.lcm, too: programs that draw its scans need the mount that the path was made with.
    if (auto* info = std::get_if<SensorInfo>(&*sample)) *info = calibration_.laser.corrected(*info);
    const auto* scan = std::get_if<LaserScan>(&*sample);
    if (scan != nullptr && is_covered(run_->edits, slam::MapEdit::Kind::drop_scans, scan->utime))
      continue;
    take(*sample);
    const std::string& fault = adapter().input().rules().get<scan_rules::RangesInMetres>().fault;
    if (!fault.empty()) throw std::invalid_argument(input.string() + ": " + fault);
    progress.update(recording.progress());
  }
  if (run_->lines != nullptr && first_key > 0) {
    require_that_lines_go_on(mapper().keys(), first_key, run_->options, input);
  }
  recorded_.inputs.push_back(recording.report());
  const std::string& odometry_fault = run_->options.odometry_fault;
  if (!odometry_fault.empty()) recorded_.inputs.back().notes.push_back(odometry_fault);
  clock_.end_stage("read and match " + input.filename().string());
}

void MapJob::take(const Sample& sample) {
  const bool is_odometry = std::holds_alternative<OdometrySample>(sample);
  if (is_odometry && !run_->options.odometry_fault.empty()) return;
  recorded_.add(sample);
  const EncodedMessage message = encode_sample(sample);
  run_->bus.deliver(message.channel, message.bytes, message.utime);
  if (is_odometry && run_->adapter.input().odometry_fault()) recorded_.odometry.clear();
}

void MapJob::finish() {
  clock_.show_stage("closing loops");
  run_->adapter.finish();
  run_->bus.deliver_published();
  clock_.end_stage("optimize");
  clock_.show_stage("meshing");
  run_->mapping3d.finish();
  const std::vector<BodyPart>& in_sweeps = run_->mapping3d.mapper().own_body();
  calibration_.body.insert(calibration_.body.end(), in_sweeps.begin(), in_sweeps.end());
  run_->bus.deliver_published();
  run_->log_file.finish();
  clock_.end_stage("model");
}

std::optional<slam::MapEvidence> MapJob::evidence() const {
  if (session() != nullptr && session()->localizer() != nullptr) return std::nullopt;
  slam::MapEvidence evidence;
  evidence.keys = mapper().keys();
  evidence.loops = mapper().loops();
  if (session() != nullptr) {
    evidence.edges = session()->slam().edges();
    // The line SLAM matches walls, and rightly none in many a scan.
    for (const slam::UsedScan& scan : adapter().scans()) {
      evidence.count(scan.hits, scan.level, scan.matched, run_->options.slam.slam.gates.min_points);
    }
  }
  const std::vector<std::optional<Pose2>> known = mapper().scan_poses();
  for (std::size_t i = 0; i < recordings_.size(); ++i) {
    const bool is_last = i + 1 == recordings_.size();
    const FirstOf end = is_last ? FirstOf{known.size(), adapter().odometry_trajectory().size()}
                                : recordings_[i + 1];
    slam::RecordedPath& recorded = evidence.paths.emplace_back();
    for (std::size_t scan = recordings_[i].scan; scan < end.scan; ++scan) {
      if (known[scan])
        recorded.path.push_back({adapter().live_trajectory()[scan].utime, *known[scan]});
    }
    const auto odometry = adapter().odometry_trajectory().begin();
    recorded.odometry.assign(odometry + static_cast<std::ptrdiff_t>(recordings_[i].odometry),
                             odometry + static_cast<std::ptrdiff_t>(end.odometry));
  }
  return evidence;
}

double MapJob::recorded_s() const {
  const Trajectory& live = adapter().live_trajectory();
  if (live.empty()) return 0.0;
  const auto [first, last] = std::minmax_element(
      live.begin(), live.end(),
      [](const StampedPose2& a, const StampedPose2& b) { return a.utime < b.utime; });
  return (last->utime - first->utime).seconds();
}

}  // namespace marco
