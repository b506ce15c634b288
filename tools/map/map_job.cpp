#include "tools/map/map_job.hpp"

#include <algorithm>

#include "common/files/tilted_scans.hpp"
#include "common/process/progress.hpp"
#include "common/process/stop_signal.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/recording.hpp"
#include "slam/process/map_folder.hpp"

namespace marco {

MapJob::MapJob(const MapOptions& options, PathMaker maker, const std::filesystem::path& folder)
    : log_file_(folder / "slam.lcm", files::Appears::when_renamed),
      log_(log_file_),
      bus_(&log_),
      slam_(maker == PathMaker::scans
                ? std::optional<slam::SlamAdapter>(std::in_place, bus_, options.slam)
                : std::optional<slam::SlamAdapter>()),
      lines_(maker == PathMaker::lines
                 ? std::optional<slam::LineLcmAdapter>(std::in_place, options.lines, bus_)
                 : std::optional<slam::LineLcmAdapter>()),
      mapping3d_(bus_, options.mapping3d) {
  if (slam_) slam_->keep_scans();
  if (lines_) lines_->keep_scans();
}

Trajectory MapJob::trajectory() const {
  if (!slam_) return lines_->mapper().trajectory();
  const std::vector<std::optional<Pose2>> poses = slam_->session().trajectory();
  Trajectory trajectory;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) trajectory.push_back({slam_->live_trajectory()[i].utime, *poses[i]});
  }
  return trajectory;
}

const Trajectory& MapJob::live_trajectory() const {
  return slam_ ? slam_->live_trajectory() : lines_->live_trajectory();
}

const Trajectory& MapJob::odometry_trajectory() const {
  return slam_ ? slam_->odometry_trajectory() : lines_->odometry_trajectory();
}

const std::vector<slam::UsedScan>& MapJob::scans() const {
  return slam_ ? slam_->scans() : lines_->scans();
}

GridMap MapJob::grid() const {
  return (slam_ ? slam_->session().grid() : lines_->mapper().grid()).to_map();
}

const std::vector<slam::KeyScan>& MapJob::key_scans() const {
  static const std::vector<slam::KeyScan> kNone;
  return slam_ ? slam_->session().keys() : kNone;
}

std::size_t MapJob::key_count() const {
  return slam_ ? slam_->session().keys().size() : lines_->mapper().key_count();
}

const std::vector<slam::Loop>& MapJob::loops() const {
  return slam_ ? slam_->slam().loops() : lines_->mapper().loops();
}

const process::DropCounter& MapJob::drops() const {
  return slam_ ? slam_->drops() : lines_->drops();
}

void MapJob::extend(const std::filesystem::path& map_folder) {
  slam_->extend(slam::load_map_folder(map_folder));
  clock_.end_stage("load map");
}

void MapJob::localize(const std::filesystem::path& map_folder) {
  slam_->localize(slam::load_map_folder(map_folder));
  clock_.end_stage("load map");
}

void MapJob::read(const std::filesystem::path& input, const ForeignTable& foreign) {
  read(*open_recording(input, foreign), input);
}

void MapJob::read_scans(const std::vector<std::filesystem::path>& scans) {
  read(*files::open_tilted_scans(scans), scans.front());
}

void MapJob::read(files::SampleReader& recording, const std::filesystem::path& input) {
  if (!inputs_.empty()) {
    if (slam_) slam_->start_session();
    if (lines_) lines_->start_session();
  }
  clock_.end_stage("recognise " + input.filename().string());
  process::Progress progress("mapping " + input.filename().string());
  while (const std::optional<Sample> sample = recording.next()) {
    process::end_if_interrupted();
    take(*sample);
    progress.update(recording.progress());
  }
  inputs_.push_back(recording.report());
  clock_.end_stage("read and match " + input.filename().string());
}

void MapJob::take(const Sample& sample) {
  if (const auto* pose = std::get_if<TruePose>(&sample)) {
    truth_.push_back({pose->utime, pose->world_from_robot});
  }
  if (const auto* info = std::get_if<SensorInfo>(&sample)) sensors_[info->channel] = *info;
  const EncodedMessage message = encode_sample(sample);
  bus_.deliver(message.channel, message.bytes, message.utime);
}

void MapJob::finish() {
  if (slam_) slam_->finish();
  if (lines_) lines_->finish();
  bus_.deliver_published();
  clock_.end_stage("optimize");
  mapping3d_.finish();
  bus_.deliver_published();
  log_file_.finish();
  clock_.end_stage("model");
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
