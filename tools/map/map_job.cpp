#include "tools/map/map_job.hpp"

#include <algorithm>

#include "common/process/progress.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/recording.hpp"

namespace marco {

MapJob::MapJob(const MapOptions& options, const std::filesystem::path& folder)
    : log_((folder / "slam.lcm").string()),
      bus_(&log_),
      slam_(bus_, options.slam),
      mapping3d_(bus_, options.mapping3d) {
  slam_.keep_scans();
}

void MapJob::read(const std::filesystem::path& input, const ForeignTable& foreign) {
  const std::unique_ptr<files::SampleReader> recording = open_recording(input, foreign);
  if (!inputs_.empty()) slam_.start_session();
  clock_.end_stage("recognise " + input.filename().string());
  process::Progress progress("mapping " + input.filename().string());
  while (const std::optional<Sample> sample = recording->next()) {
    take(*sample);
    progress.update(recording->progress());
  }
  inputs_.push_back(recording->report());
  clock_.end_stage("read and match " + input.filename().string());
}

void MapJob::take(const Sample& sample) {
  if (const auto* pose = std::get_if<TruePose>(&sample)) {
    truth_.push_back({pose->utime, pose->world_from_robot});
  }
  const EncodedMessage message = encode_sample(sample);
  bus_.deliver(message.channel, message.bytes, message.utime);
}

void MapJob::finish() {
  slam_.finish();
  bus_.deliver_published();
  clock_.end_stage("optimize");
  mapping3d_.finish();
  bus_.deliver_published();
  log_.flush();
  clock_.end_stage("model");
}

double MapJob::recorded_s() const {
  const Trajectory& live = slam_.live_trajectory();
  if (live.empty()) return 0.0;
  const auto [first, last] = std::minmax_element(
      live.begin(), live.end(),
      [](const StampedPose2& a, const StampedPose2& b) { return a.utime < b.utime; });
  return (last->utime - first->utime).seconds();
}

}  // namespace marco
