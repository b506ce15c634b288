#include "tools/map/map_job.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/process/progress.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/convert.hpp"
#include "recordings/recording.hpp"
#include "slam/process/map_folder.hpp"
#include "slam/session/merge_maps.hpp"

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

std::unique_ptr<slam::Mapper2dAdapter> adapter_of(PathMaker maker,
                                                  const MapOptions& options,
                                                  process::Bus& bus) {
  if (maker == PathMaker::lines) {
    return std::make_unique<slam::LineSlamAdapter>(lines_of(options), bus);
  }
  return std::make_unique<slam::SlamAdapter>(bus, options.slam);
}

}  // namespace

MapJob::MapJob(const MapOptions& options,
               PathMaker maker,
               const std::filesystem::path& folder,
               Logged logged)
    : log_file_(folder / "slam.lcm", files::Appears::when_renamed),
      log_(log_file_),
      bus_(&log_, logged),
      mapper2d_(adapter_of(maker, options, bus_)),
      slam_(dynamic_cast<slam::SlamAdapter*>(mapper2d_.get())),
      lines_(dynamic_cast<slam::LineSlamAdapter*>(mapper2d_.get())),
      mapping3d_(bus_, mapping3d_of(options)),
      slam_options_(options.slam.slam),
      localizer_options_(options.slam.localizer),
      laser_(options.slam.input.calibration.laser),
      beams_(options.slam.input.calibration.beams),
      own_body_(options.slam.input.calibration.body),
      floor_(options.slam.input.calibration.floor),
      odometry_fault_(options.odometry_fault) {
  mapper2d_->keep_scans();
}

Trajectory MapJob::trajectory() const {
  const std::vector<std::optional<Pose2>> known = poses();
  Trajectory trajectory;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i]) trajectory.push_back({live_trajectory()[i].utime, *known[i]});
  }
  return trajectory;
}

const std::vector<slam::Keyframe>& MapJob::keyframes() const {
  static const std::vector<slam::Keyframe> kNone;
  return slam_ != nullptr ? slam_->session().keys() : kNone;
}

void MapJob::extend(const std::filesystem::path& map_folder) {
  slam_->extend(slam::load_map_folder(map_folder));
  clock_.end_stage("load map");
}

void MapJob::localize(const std::filesystem::path& map_folder,
                      const std::optional<Pose2>& map_from_robot) {
  slam_->localize(slam::load_map_folder(map_folder));
  if (map_from_robot) slam_->set_pose(*map_from_robot);
  clock_.end_stage("load map");
}

void MapJob::set_edits(const slam::MapEdits& edits) {
  edits_ = edits;
  slam_->set_edits(edits);
}

void MapJob::read(const RecordingParts& parts, const ForeignTable& foreign) {
  read(*open_recording(parts, foreign), parts.front());
}

void MapJob::read(files::SampleReader& recording, const std::filesystem::path& input) {
  if (!recorded_.inputs.empty()) mapper2d_->start_session();
  recordings_.push_back({live_trajectory().size(), odometry_trajectory().size()});
  const std::size_t first_key = key_count();
  process::Progress progress("mapping " + input.filename().string());
  while (std::optional<Sample> sample = recording.next()) {
    process::end_if_interrupted();
    // In slam.lcm, too: programs that draw its scans need the mount that the path was made with.
    if (auto* info = std::get_if<SensorInfo>(&*sample)) *info = laser_.corrected(*info);
    const auto* scan = std::get_if<LaserScan>(&*sample);
    if (scan != nullptr && is_covered(edits_, slam::MapEdit::Kind::drop_scans, scan->utime))
      continue;
    take(*sample);
    const std::string& fault = scan_rules().get<scan_rules::RangesInMetres>().fault;
    if (!fault.empty()) throw std::invalid_argument(input.string() + ": " + fault);
    progress.update(recording.progress());
  }
  if (lines_ != nullptr && first_key > 0) check_that_lines_go_on(first_key, input);
  recorded_.inputs.push_back(recording.report());
  if (!odometry_fault_.empty()) recorded_.inputs.back().notes.push_back(odometry_fault_);
  clock_.end_stage("read and match " + input.filename().string());
}

void MapJob::check_that_lines_go_on(std::size_t first_key,
                                    const std::filesystem::path& input) const {
  const std::vector<slam::Keyframe>& keys = lines_->mapper().keys();
  const auto middle = keys.begin() + static_cast<std::ptrdiff_t>(first_key);
  const std::vector<slam::Keyframe> session(middle, keys.end());
  slam::FrozenMap before({keys.begin(), middle}, localizer_options_, slam_options_);
  const auto found = slam::find_session(before, session, localizer_options_);
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

void MapJob::take(const Sample& sample) {
  if (const auto* pose = std::get_if<TruePose>(&sample)) {
    recorded_.truth.add(*pose);
  }
  const auto* odometry = std::get_if<OdometrySample>(&sample);
  if (odometry != nullptr && !odometry_fault_.empty()) return;
  if (const auto* imu = std::get_if<ImuSample>(&sample)) integrate(*imu);
  if (const auto* scan = std::get_if<LaserScan>(&sample)) note_bearings(*scan);
  if (const auto* info = std::get_if<SensorInfo>(&sample)) note_sensor(recorded_.sensors, *info);
  const EncodedMessage message = encode_sample(sample);
  bus_.deliver(message.channel, message.bytes, message.utime);
  if (odometry == nullptr) return;
  if (mapper2d_->input().odometry_fault()) {
    recorded_.odometry.clear();
  } else {
    recorded_.odometry.push_back({odometry->utime, odometry->odom_from_robot});
  }
}

void MapJob::note_bearings(const LaserScan& scan) {
  if (scan.size() == 0 || recorded_.least_bearing_rad.contains(scan.channel)) return;
  double least_rad = scan.bearing_rad(0);
  for (std::size_t i = 1; i < scan.size(); ++i)
    least_rad = std::min(least_rad, scan.bearing_rad(i));
  recorded_.least_bearing_rad[scan.channel] = least_rad;
}

void MapJob::integrate(const ImuSample& sample) {
  double heading_rad = 0.0;
  if (!recorded_.gyro_heading.empty()) {
    const StampedPose2& last = recorded_.gyro_heading.back();
    if (sample.utime <= last.utime) return;
    heading_rad = integrated_heading_rad(last, sample).value_or(last.world_from_robot.theta_rad);
  }
  recorded_.gyro_heading.push_back({sample.utime, {0.0, 0.0, heading_rad}});
}

void MapJob::finish() {
  clock_.show_stage("closing loops");
  mapper2d_->finish();
  bus_.deliver_published();
  clock_.end_stage("optimize");
  clock_.show_stage("meshing");
  mapping3d_.finish();
  const std::vector<BodyPart>& in_sweeps = mapping3d_.mapper().own_body();
  own_body_.insert(own_body_.end(), in_sweeps.begin(), in_sweeps.end());
  bus_.deliver_published();
  log_file_.finish();
  clock_.end_stage("model");
}

std::optional<slam::MapEvidence> MapJob::evidence() const {
  if (session() != nullptr && session()->localizer() != nullptr) return std::nullopt;
  slam::MapEvidence evidence;
  evidence.keys = mapper().keys();
  evidence.loops = loops();
  if (session() != nullptr) {
    evidence.edges = session()->slam().edges();
    // The line SLAM matches walls, and rightly none in many a scan.
    for (const slam::UsedScan& scan : scans()) {
      evidence.count(scan.hits, scan.level, scan.matched, slam_options_.gates.min_points);
    }
  }
  const std::vector<std::optional<Pose2>> known = poses();
  for (std::size_t i = 0; i < recordings_.size(); ++i) {
    const bool is_last = i + 1 == recordings_.size();
    const FirstOf end =
        is_last ? FirstOf{known.size(), odometry_trajectory().size()} : recordings_[i + 1];
    slam::RecordedPath& recorded = evidence.paths.emplace_back();
    for (std::size_t scan = recordings_[i].scan; scan < end.scan; ++scan) {
      if (known[scan]) recorded.path.push_back({live_trajectory()[scan].utime, *known[scan]});
    }
    const auto odometry = odometry_trajectory().begin();
    recorded.odometry.assign(odometry + static_cast<std::ptrdiff_t>(recordings_[i].odometry),
                             odometry + static_cast<std::ptrdiff_t>(end.odometry));
  }
  return evidence;
}

double MapJob::recorded_s() const {
  const Trajectory& live = live_trajectory();
  if (live.empty()) return 0.0;
  const auto [first, last] = std::minmax_element(
      live.begin(), live.end(),
      [](const StampedPose2& a, const StampedPose2& b) { return a.utime < b.utime; });
  return (last->utime - first->utime).seconds();
}

}  // namespace marco
