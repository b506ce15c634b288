#include "tools/bridge/marco_side.hpp"

#include <limits>

#include "common/map_tiles.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/slam_command_t.hpp"

namespace marco::bridge {
namespace {

// Tiles of a map come in one burst.
constexpr double kBurstEndsS = 0.3;
constexpr double kAnnounceEveryS = 1.0;

}  // namespace

MarcoSide::MarcoSide(process::LcmBus& bus, process::DropCounter& drops, Listener listener)
    : bus_(bus), drops_(drops), listener_(std::move(listener)) {
  subscribe();
}

void MarcoSide::subscribe() {
  bus_.subscribe<slam_pose_t>(channels::kSlamPose, drops_, [this](const auto& message, auto&) {
    const PoseEstimate estimate = from_message(message);
    if (estimate.status == PoseEstimate::Status::lost) return;
    ++poses_;
    world_from_robot_ = estimate.world_from_robot;
    listener_.pose(estimate);
  });
  bus_.subscribe<trajectory_t>(channels::kTrajectory, drops_, [this](const auto& message, auto&) {
    listener_.path(from_message(message), Utime::from_us(message.utime));
  });
  bus_.subscribe<grid_map_t>(channels::kGridMap, drops_, [this](const auto& message, auto&) {
    view_.add_tile(from_message(message), message.revision);
    newest_tile_ = Utime::from_us(message.utime);
    has_new_tiles_ = tiles_came_ = true;
  });
}

void MarcoSide::publish(const Sample& sample) {
  const EncodedMessage message = encode_sample(sample);
  bus_.publish_raw(message.channel, message.bytes, message.utime);
}

void MarcoSide::give(const Sample& sample) {
  if (const auto* info = std::get_if<SensorInfo>(&sample)) sensors_[info->channel] = *info;
  scans_ += std::holds_alternative<LaserScan>(sample);
  odometry_ += std::holds_alternative<OdometrySample>(sample);
  publish(sample);
}

void MarcoSide::reset(Reset what) {
  slam_command_t command = {};
  command.utime = process::wall_clock_us();
  command.command = slam_command_t::RESET;
  if (what == Reset::map_only) {
    command.command = slam_command_t::SET_POSE;  // begins a new map, too
    command.x_m = world_from_robot_.x_m;
    command.y_m = world_from_robot_.y_m;
    command.theta_rad = world_from_robot_.theta_rad;
  }
  view_.map_tiles.clear();
  has_new_tiles_ = false;
  bus_.publish(channels::kSlamCommand, command);
}

void MarcoSide::tick(double now_s) {
  if (now_s - announced_s_ >= kAnnounceEveryS) {
    announced_s_ = now_s;
    for (const auto& [channel, info] : sensors_) publish(info);
  }
  if (std::exchange(tiles_came_, false)) tiles_since_s_ = now_s;
  if (!has_new_tiles_ || now_s - tiles_since_s_ < kBurstEndsS) return;
  has_new_tiles_ = false;
  std::vector<const GridMap*> tiles;
  for (const auto& [origin, tile] : view_.map_tiles) tiles.push_back(&tile);
  const auto map = join_tiles(tiles, std::numeric_limits<double>::infinity());
  if (!map) return;
  ++maps_;
  listener_.map(*map, newest_tile_);
}

}  // namespace marco::bridge
