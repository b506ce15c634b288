#include "slam/process/line_slam_adapter.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "slam/process/line_journal.hpp"

namespace marco::slam {
LineSlamAdapter::LineSlamAdapter(const LineProcessOptions& options,
                                 process::Bus& bus,
                                 std::function<void(const std::string&)> warn)
    : Mapper2dAdapter(bus, options, channels::kLineMap, std::move(warn)),
      options_(options),
      mapper_(options.mapper) {
  validate(options, "line_process");
  if (!options_.checkpoint_path.empty()) {
    if (const auto checkpoint = load_checkpoint(options_.checkpoint_path)) {
      mapper_.restore(checkpoint->mapper);
      last_scan_ = progress_.newest_scan = checkpoint->utime;
      map_revision_ = checkpoint->map_revision;
      resumed_ = true;
    }
  }
  if (!options_.journal_path.empty()) {
    journal_.open(options_.journal_path, std::ios::app);
    require(journal_.good(), "journal_path: cannot write " + options_.journal_path);
  }
}

MappedScan LineSlamAdapter::map_scan(const SynchronizedScan& scan, bool may_draw) {
  const Utime utime = last_scan_.emplace(scan.motion.utime);
  const ScanVelocity velocity = mapper_.velocity_during(scan.odometry_step, scan.duration_s);
  SlamInput input = slam_input(scan, velocity);
  input.may_draw = may_draw;
  ScanInRobot beams;
  if (scan.level) {
    beams = to_robot_frame(scan.scan, scan.info, scan.robot_from_sensor, input.scan,
                           options_.mapper.lines.lines.range_sigma_m);
    ++scans_used_;
  } else {
    drops_.count("tilted");
  }
  LineSlamJournal journal;
  const LineSlamUpdate update =
      mapper_.process(input, beams, journal_.is_open() ? &journal : nullptr);
  if (journal_.is_open() && update.looked) journal_ << journal_line(utime, journal) << '\n';
  MappedScan mapped;
  mapped.used = used_scan(std::move(input), scan.level && update.matched > 0);
  // Walls just added are matched by definition: the first scan has a pose, too.
  const bool matched = scan.level && (update.matched > 0 || progress_.scan_count == 1);
  mapped.estimate = {utime, update.world_from_robot, update.covariance,
                     matched ? PoseEstimate::Status::matched : PoseEstimate::Status::predicted,
                     update.overlap};
  mapped.trajectory_changed = update.trajectory_changed;
  return mapped;
}

void LineSlamAdapter::publish_map(Utime utime) {
  if (!last_scan_) return;
  LineMap map = mapper_.map();
  for (RoundWall& round : map.round_walls) {
    round.id = -round.id;
    const Walls chords = chords_of(round);
    map.walls.insert(map.walls.end(), chords.begin(), chords.end());
  }
  bus_.publish(channels::kLineMap, to_message(map.walls, utime, ++map_revision_));
}

std::string LineSlamAdapter::mapping_line() const {
  return std::to_string(mapper_.filter().num_walls()) + " walls";
}

LineCheckpoint LineSlamAdapter::checkpoint() {
  return {last_scan_.value_or(Utime{}), map_revision_, mapper_.store()};
}

std::function<void()> LineSlamAdapter::checkpoint_job() {
  return [path = options_.checkpoint_path, now = checkpoint()] { save_checkpoint(path, now); };
}

void LineSlamAdapter::reset(const Pose2& world_from_robot) {
  mapper_ = LineMapper(options_.mapper, world_from_robot);
}

std::string LineSlamAdapter::execute_on_map(const SlamOrder& order) {
  const auto path = order.folder / "line_slam.checkpoint";
  switch (order.command) {
    case slam_command_t::SAVE:
      return orders_.write([path, now = checkpoint()] {
        save_checkpoint(path.string(), now);
        return "SAVE " + path.string() + ": saved";
      });
    case slam_command_t::LOCALIZE:
      throw std::invalid_argument("LOCALIZE: the line SLAM cannot relocalize");
    case slam_command_t::EXTEND:
      throw std::invalid_argument("EXTEND: the line SLAM cannot relocalize");
    case slam_command_t::RESET:
      reset({});
      return "RESET: starting a new map";
    default:  // SET_POSE
      reset(order.world_from_robot);
      return "SET_POSE: starting a new map from there";
  }
}

void LineSlamAdapter::finish() {
  Mapper2dAdapter::finish();
  if (!last_scan_) return;
  if (!options_.checkpoint_path.empty()) save_checkpoint(options_.checkpoint_path, checkpoint());
  if (journal_.is_open()) journal_.flush();
}

}  // namespace marco::slam
