#include "slam/process/line_slam_adapter.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "slam/process/line_journal.hpp"

namespace marco::slam {
namespace {

// The motion that odometry measured during the scan undone.
DeskewedScan deskew(const SynchronizedScan& scan) {
  const bool moved = scan.odometry_step && scan.duration_s > 0.0;
  const Velocity2 velocity =
      moved ? velocity_of(*scan.odometry_step, scan.duration_s) : Velocity2{};
  return deskew_and_project(scan.scan, scan.info, scan.robot_from_sensor, velocity);
}

}  // namespace

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
      odom_at_last_scan_ = checkpoint->odom_from_robot;
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

std::optional<Pose2> LineSlamAdapter::motion_to(const MotionInput& now) {
  const std::optional<Pose2> before = std::exchange(odom_at_last_scan_, now.odom_from_robot);
  const std::optional<Utime> last = std::exchange(last_scan_, now.utime);
  if (!last) return Pose2{};
  if (!now.odom_from_robot || !before) return std::nullopt;
  const Pose2 motion = between(*before, *now.odom_from_robot);
  const double seconds = std::max(0.1, std::abs((now.utime - *last).seconds()));
  if (motion.translation_m().norm() > options_.max_speed_m_per_s * seconds) {
    drops_.count("odometry jumps");
    return std::nullopt;
  }
  return motion;
}

MappedScan LineSlamAdapter::map_scan(const SynchronizedScan& scan, bool may_draw) {
  const Utime utime = scan.scan.utime;
  const std::optional<Pose2> motion = motion_to(scan.motion);
  MappedScan mapped;
  UsedScan& used = mapped.used;
  used.level = scan.level;
  used.held_out = !may_draw;
  used.deskewed.utime = utime;
  LineSlamUpdate update;
  if (scan.level) {
    used.deskewed = deskew(scan);
    const ScanInRobot beams =
        to_robot_frame(scan.scan, scan.info, scan.robot_from_sensor, used.deskewed,
                       options_.mapper.lines.lines.range_sigma_m);
    LineSlamJournal journal;
    update = mapper_.process(beams, utime, motion, may_draw ? MapUse::draw : MapUse::pose_only,
                             journal_.is_open() ? &journal : nullptr);
    if (journal_.is_open() && update.looked) journal_ << journal_line(utime, journal) << '\n';
    ++scans_used_;
    if (!motion) ++scans_guessed_;
  } else {
    drops_.count("tilted");
    update = mapper_.carry(utime, motion.value_or(Pose2{}));
  }
  used.matched = scan.level && update.matched > 0;
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
  bus_.publish(channels::kLineMap, to_message(mapper_.plan(), utime, ++map_revision_));
}

std::string LineSlamAdapter::mapping_line() const {
  return std::to_string(mapper_.filter().num_walls()) + " walls";
}

LineCheckpoint LineSlamAdapter::checkpoint() {
  return {last_scan_.value_or(Utime{}), odom_at_last_scan_, map_revision_, mapper_.store()};
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
      return "RESET: a new map is started";
    default:  // SET_POSE
      reset(order.world_from_robot);
      return "SET_POSE: a new map is started from there";
  }
}

void LineSlamAdapter::finish() {
  Mapper2dAdapter::finish();
  if (!last_scan_) return;
  if (!options_.checkpoint_path.empty()) save_checkpoint(options_.checkpoint_path, checkpoint());
  if (journal_.is_open()) journal_.flush();
}

}  // namespace marco::slam
