#include "slam/process/mapper2d_adapter.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "live/sensor_feed.hpp"
#include "marco/map_request_t.hpp"
#include "slam/back_end/loops_in_force.hpp"

namespace marco::slam {

bool CheckpointWriter::is_due(Utime utime) {
  if (!saved_) saved_ = utime;
  if (std::abs((utime - *saved_).seconds()) < every_s_ || job_.busy()) return false;
  saved_ = utime;
  return true;
}

void CheckpointWriter::write_in_foreground() {
  if (const std::string failure = job_.wait(); !failure.empty()) drops_.count(failure);
  in_background_ = false;
}

void CheckpointWriter::write(std::function<void()> job) {
  const auto quietly = [job = std::move(job)]() -> std::string {
    try {
      job();
      return "";
    } catch (const std::runtime_error&) {  // a full disk must not end the mapping
      return "checkpoint: cannot be written";
    }
  };
  const auto count = [this](const std::string& failure) {
    if (!failure.empty()) drops_.count(failure);
  };
  if (!in_background_) return count(quietly());
  count(job_.take_reply());
  job_.start(quietly);
}

Mapper2dAdapter::Mapper2dAdapter(process::Bus& bus,
                                 const Mapper2dAdapterOptions& options,
                                 const char* map_channel,
                                 std::function<void(const std::string&)> warn)
    : bus_(bus),
      drops_(std::move(warn)),
      input_(options.input,
             lcm_channel_names(),
             [this](const std::string& cause) { drops_.count(cause); }),
      checkpoints_(options.checkpoint_every_s, drops_),
      options_(options) {
  subscribe(map_channel);
}

void Mapper2dAdapter::subscribe(const char* map_channel) {
  const auto accept = [this](const LaserScan&) {
    if (paused_) drops_.count("paused");
    return !paused_;
  };
  feed(bus_, drops_, input_, {accept, [this] { use_complete_scans(); }});
  bus_.subscribe<map_request_t>(channels::kMapRequest, drops_,
                                [this, map_channel](const auto& request, auto&) {
                                  const bool all = request.channel.empty();
                                  if (all || request.channel == channels::kTrajectory) {
                                    publish_trajectory(progress_.newest_scan);
                                  }
                                  if (all || request.channel == map_channel)
                                    publish_map(progress_.newest_scan);
                                });
  bus_.subscribe<slam_command_t>(
      channels::kSlamCommand, drops_, [this](const auto& command, const auto& raw) {
        orders_.take(command, raw.event_time, options_.maps_folder,
                     [this](const SlamOrder& order) { return execute_command(order); });
      });
}

void Mapper2dAdapter::use_complete_scans() {
  while (const std::optional<SynchronizedScan> scan = input_.next()) use(*scan);
}

void Mapper2dAdapter::use(const SynchronizedScan& scan) {
  const Utime utime = scan.scan.utime;
  progress_.newest_scan = utime;
  ++progress_.scan_count;
  const int every = options_.hold_out_every;
  MappedScan mapped = map_scan(scan, every == 0 || progress_.scan_count % every != 0);
  if (path_is_kept_) {
    progress_.live.push_back({utime, mapped.estimate.world_from_robot});
    if (scan.motion.odom_from_robot) {
      progress_.odometry_at_scans.push_back({utime, *scan.motion.odom_from_robot});
    }
  }
  if (keep_scans_) progress_.scans.push_back(std::move(mapped.used));
  bus_.publish(channels::kSlamPose, to_message(mapped.estimate));
  if (mapped.trajectory_changed) publish_trajectory(utime);
  // A clock that steps back must not end what is published at intervals.
  const double since_map_s = std::abs((utime - progress_.last_map).seconds());
  if (options_.map_period_s > 0.0 && since_map_s >= options_.map_period_s) {
    progress_.last_map = utime;
    publish_trajectory(utime);
    publish_map(utime);
  }
  if (options_.checkpoint_path.empty() || !checkpoints_.is_due(utime)) return;
  if (auto job = checkpoint_job()) checkpoints_.write(std::move(job));
}

void Mapper2dAdapter::publish_trajectory(Utime utime) {
  const Mapper2d& mapper = mapper2d();
  bus_.publish(channels::kTrajectory,
               to_message(mapper.key_trajectory(), utime, mapper.revision()));
  bus_.publish(channels::kLoopClosures,
               to_message(loops_in_force(mapper.loops(), mapper.keys()), utime, mapper.revision()));
}

void Mapper2dAdapter::write_in_background() {
  orders_.write_in_background();
  checkpoints_.write_in_background();
}

void Mapper2dAdapter::keep_no_path() {
  path_is_kept_ = false;
  progress_.live = {};
  progress_.odometry_at_scans = {};
}

std::string Mapper2dAdapter::execute_command(const SlamOrder& order) {
  if (order.command == slam_command_t::PAUSE || order.command == slam_command_t::RESUME) {
    paused_ = order.command == slam_command_t::PAUSE;
    return paused_ ? "PAUSE: scans are ignored" : "RESUME: mapping continues";
  }
  return execute_on_map(order);
}

std::string Mapper2dAdapter::state_line() const {
  if (paused_) return "paused";
  const std::string notice = input_.notice();
  return (notice.empty() ? "" : notice + "; ") + std::to_string(progress_.scan_count) + " scans, " +
         mapping_line();
}

void Mapper2dAdapter::start_session() {
  input_.start_session();
  use_complete_scans();
  start_mapper_session();
}

void Mapper2dAdapter::finish() {
  input_.complete_all();
  use_complete_scans();
  finish_mapping();
  orders_.wait();
  if (progress_.scan_count == 0) return;
  publish_trajectory(progress_.newest_scan);
  publish_map(progress_.newest_scan);
}

}  // namespace marco::slam
