#include "mapping3d/process/mapping3d_adapter.hpp"

#include <utility>

#include "lcm_tools/process/status_publisher.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "live/sensor_feed.hpp"
#include "mapping3d/process/model_messages.hpp"
#include "marco/map_request_t.hpp"

namespace marco::mapping3d {

Mapping3dAdapter::Mapping3dAdapter(process::Bus& bus,
                                   const Mapping3dAdapterOptions& options,
                                   std::function<void(const std::string&)> warn)
    : bus_(bus),
      drops_(std::move(warn)),
      mapper_(options.mapper),
      input_(
          options.input, lcm_channel_names(), [this](const auto& cause) { drops_.count(cause); }),
      rows_(options.correction, options.input.patience_s, [this](const auto& cause) {
        drops_.count(cause);
      }) {
  validate(options, "mapping3d_process");
  subscribe();
}

void Mapping3dAdapter::subscribe() {
  feed(bus_, drops_, input_,
       {[this](const LaserScan& scan) { return is_wanted(scan); },
        [this] { use_complete_scans(); }});
  bus_.subscribe<slam_pose_t>(channels::kSlamPose, drops_, [this](const auto& message, auto&) {
    const PoseEstimate pose = from_message(message);
    // What is seen from a pose in no map would be laid over the map.
    require(pose.status != PoseEstimate::Status::lost, "slam_pose_t: SLAM is lost");
    rows_.add(pose);
    use_complete_scans();
  });
  bus_.subscribe<trajectory_t>(channels::kTrajectory, drops_, [this](const auto& message, auto&) {
    follow(from_message(message));
  });
  bus_.subscribe<map_request_t>(channels::kMapRequest, drops_, [this](const auto& request, auto&) {
    if (request.channel.empty() || request.channel == channels::kMesh) {
      refine();
      publish_model();
    }
  });
}

bool Mapping3dAdapter::is_wanted(const LaserScan& scan) {
  const SensorInfo* info = input_.sensor_of(scan.channel);
  if (info == nullptr) return false;
  if (info->mount == SensorInfo::Mount::robot && !is_steep(info->parent_from_sensor)) return false;
  if (has_even_bearings(scan)) return true;
  drops_.count("scan with irregular bearings: not a row of a scene");
  return false;
}

void Mapping3dAdapter::follow(const Trajectory& keys) {
  const PathCorrection correction = rows_.correction_by(keys);
  mapper_.follow(correction);
  rows_.follow(correction);
}

void Mapping3dAdapter::use_complete_scans() {
  while (std::optional<SynchronizedScan> scan = input_.next()) rows_.add(std::move(*scan));
  while (const std::optional<PlacedRow> placed = rows_.next(input_.pantilt_base())) {
    if (mapper_.add(placed->row, placed->pan_rad, placed->tilt_rad, placed->laser)) {
      publish_scene(mapper_.scenes().back());
    }
  }
}

void Mapping3dAdapter::refine() {
  if (on_long_work_) {
    on_long_work_(process::kBusy + ("joining " + std::to_string(mapper_.scenes().size())) +
                  " scenes");
  }
  const std::size_t known = mapper_.own_body().size();
  mapper_.refine();
  const std::vector<BodyPart>& body = mapper_.own_body();
  if (body.size() > known) drops_.count(describe(body) + ": these returns are ignored");
}

void Mapping3dAdapter::publish_scene(const Scene& scene) {
  for (const scene_t& message : scene_messages(scene)) bus_.publish(channels::kScene, message);
}

void Mapping3dAdapter::publish_model() {
  for_each_tile(mapper_.model(), rows_.newest(), ++revision_,
                [this](const mesh_t& tile) { bus_.publish(channels::kMesh, tile); });
}

void Mapping3dAdapter::finish() {
  input_.complete_all();
  rows_.complete_all();
  use_complete_scans();
  const std::vector<Scene>& scenes = mapper_.scenes();
  const std::size_t ended = mapper_.finish();
  for (std::size_t i = scenes.size() - ended; i < scenes.size(); ++i) publish_scene(scenes[i]);
  refine();
  if (!mapper_.scenes().empty()) publish_model();
}

std::optional<CalibrationResult> Mapping3dAdapter::calibrate(
    const CalibrationOptions& options) const {
  const SensorInfo* base = input_.pantilt_base();
  if (base == nullptr || mapper_.scenes().empty()) return std::nullopt;
  for (const auto& [channel, info] : input_.sensors()) {
    if (info.mount == SensorInfo::Mount::pantilt) {
      return marco::mapping3d::calibrate(mapper_.scenes(), {*base, info}, options);
    }
  }
  return std::nullopt;
}

}  // namespace marco::mapping3d
