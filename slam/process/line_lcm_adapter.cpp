#include "slam/process/line_lcm_adapter.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "slam/input/odometry_restart.hpp"
#include "slam/process/line_journal.hpp"

namespace marco::slam {
namespace {

constexpr std::size_t kMaxWaiting = 200;
constexpr std::size_t kPanTiltStates = 200;

double tilt_of(const Pose3& robot_from_sensor) {
  return std::acos(std::clamp(std::abs(robot_from_sensor.linear()(2, 2)), 0.0, 1.0));
}

bool is_after(Utime utime, Utime last, double seconds) {
  // A log whose clock steps back must not silence what is sent at intervals.
  return std::abs((utime - last).seconds()) >= seconds;
}

}  // namespace

LineLcmAdapter::LineLcmAdapter(const LineProcessOptions& options,
                               process::Bus& bus,
                               std::function<void(const std::string&)> warn)
    : options_(options), bus_(bus), drops_(std::move(warn)), mapper_(options.mapper) {
  validate(options, "line_process");
  if (!options_.checkpoint_path.empty()) {
    if (const auto checkpoint = load_checkpoint(options_.checkpoint_path)) {
      mapper_.restore(checkpoint->mapper);
      odom_at_last_scan_ = checkpoint->odom_from_robot;
      last_scan_ = checkpoint->utime;
      map_revision_ = checkpoint->map_revision;
      resumed_ = true;
    }
  }
  if (!options_.journal_path.empty()) {
    journal_.open(options_.journal_path, std::ios::app);
    require(journal_.good(), "journal_path: cannot write " + options_.journal_path);
  }
  subscribe();
}

void LineLcmAdapter::subscribe() {
  using process::RawMessage;
  bus_.subscribe<sensor_info_t>(
      channels::kSensorInfo, drops_, [this](const sensor_info_t& message, const RawMessage&) {
        require(note_sensor(sensors_, from_message(message)), kTooManySensors);
      });
  bus_.subscribe<odometry_t>(channels::kOdometry, drops_,
                             [this](const odometry_t& message, const RawMessage&) {
                               const OdometrySample sample = from_message(message);
                               if (odometry_began_anew(odometry_, sample)) forget_odometry();
                               odometry_.add(sample.utime, sample.odom_from_robot);
                               take_waiting(Patience::waits);
                             });
  bus_.subscribe<pantilt_state_t>(channels::kPanTiltState, drops_,
                                  [this](const pantilt_state_t& message, const RawMessage&) {
                                    pantilt_.push_back(from_message(message));
                                    if (pantilt_.size() > kPanTiltStates) pantilt_.pop_front();
                                  });
  if (options_.lidar_channel == channels::kLidarRaw) {
    bus_.subscribe<lidar_raw_t>(options_.lidar_channel, drops_,
                                [this](const lidar_raw_t& message, const RawMessage&) {
                                  on_scan(from_message(message, options_.lidar_channel));
                                });
  } else {
    bus_.subscribe<bot_core::planar_lidar_t>(
        options_.lidar_channel, drops_,
        [this](const bot_core::planar_lidar_t& message, const RawMessage&) {
          on_scan(from_message(message, options_.lidar_channel));
        });
  }
  bus_.subscribe<slam_command_t>(
      channels::kSlamCommand, drops_, [this](const slam_command_t& message, const RawMessage&) {
        orders_.take(message, options_.save_folder,
                     [this](const SlamOrder& order) { return obey(order); });
      });
  bus_.subscribe<map_request_t>(
      channels::kMapRequest, drops_, [this](const map_request_t& message, const RawMessage&) {
        if (message.channel.empty() || message.channel == channels::kLineMap) {
          publish_map();
        }
      });
}

void LineLcmAdapter::on_scan(LaserScan scan) {
  if (paused_) return drops_.count("paused");
  require(scan.size() >= 2, "scan has fewer than two beams");
  if (!sensors_.contains(scan.channel)) return drops_.count("no SENSOR_INFO for " + scan.channel);
  if (const auto wrong = range_units_.look(scan)) return drops_.count(*wrong);
  if (!one_source_) return let_wait(std::move(scan));
  for (LaserScan& own : take_own(*one_source_, std::move(scan), drops_)) let_wait(std::move(own));
}

void LineLcmAdapter::let_wait(LaserScan scan) {
  waiting_.push_back(std::move(scan));
  take_waiting(waiting_.size() > kMaxWaiting ? Patience::is_over : Patience::waits);
}

void LineLcmAdapter::hear_lasers_anew() {
  if (!one_source_) return;
  for (LaserScan& scan : one_source_->rest()) let_wait(std::move(scan));
  one_source_.emplace();
}

void LineLcmAdapter::forget_odometry() {
  // What still waits was measured before.
  take_waiting(Patience::is_over);
  drops_.count("odometry began anew: none for a scan");
  odometry_.clear();
  odom_at_last_scan_.reset();
}

bool LineLcmAdapter::odometry_covers(const LaserScan& scan) const {
  const double duration_s = sensors_.at(scan.channel).scan_duration_s;
  return !odometry_.empty() &&
         odometry_.newest() >= scan.utime + Duration::from_seconds(duration_s);
}

void LineLcmAdapter::take_waiting(Patience patience) {
  while (!waiting_.empty()) {
    const LaserScan& first = waiting_.front();
    const double waited_s = (waiting_.back().utime - first.utime).seconds();
    // A stamp that steps back says nothing of waiting: then what is there must do.
    const bool waits = patience == Patience::waits && !odometry_covers(first) && waited_s >= 0.0 &&
                       waited_s < options_.odometry_wait_s;
    if (waits) return;
    const LaserScan scan = std::move(waiting_.front());
    waiting_.pop_front();
    take(scan);
  }
}

std::optional<SensorInfo> LineLcmAdapter::effective_info(const LaserScan& scan, bool& is_tilted) {
  SensorInfo info = sensors_.at(scan.channel);
  if (info.mount == SensorInfo::Mount::pantilt) {
    const auto base = sensors_.find(channels::kPanTiltState);
    if (base == sensors_.end() || pantilt_.empty()) return std::nullopt;
    // The newest state not after the scan; the oldest known when all are.
    const PanTiltState* state = &pantilt_.front();
    for (const PanTiltState& candidate : pantilt_) {
      if (candidate.utime <= scan.utime) state = &candidate;
    }
    info.parent_from_sensor =
        robot_from_pantilt_sensor(base->second, info, state->pan_rad, state->tilt_rad);
  }
  is_tilted = tilt_of(info.parent_from_sensor) > deg_to_rad(options_.max_tilt_deg);
  return info;
}

std::optional<Pose2> LineLcmAdapter::motion_to(Utime utime, std::optional<Pose2>& odom_from_robot) {
  odom_from_robot = odometry_.at(utime, Duration::from_seconds(options_.odometry_wait_s));
  if (!last_scan_) return Pose2{};
  if (!odom_from_robot || !odom_at_last_scan_) return std::nullopt;
  const Pose2 motion = between(*odom_at_last_scan_, *odom_from_robot);
  const double seconds = std::max(0.1, std::abs((utime - *last_scan_).seconds()));
  if (motion.translation_m().norm() > options_.max_speed_m_per_s * seconds) {
    drops_.count("odometry jumps");
    return std::nullopt;
  }
  return motion;
}

void LineLcmAdapter::take(const LaserScan& scan) {
  bool is_tilted = false;
  const std::optional<SensorInfo> info = effective_info(scan, is_tilted);
  if (!info) return drops_.count("no PANTILT_STATE yet");
  std::optional<Pose2> odom_from_robot;
  const std::optional<Pose2> motion = motion_to(scan.utime, odom_from_robot);
  LineSlamUpdate update;
  const auto number = static_cast<int64_t>(live_.size()) + 1;
  const bool held_out = options_.hold_out_every > 0 && number % options_.hold_out_every == 0;
  if (is_tilted) {
    drops_.count("tilted");
    ++scans_carried_;
    update = mapper_.carry(scan.utime, motion.value_or(Pose2{}));
  } else {
    const Duration length = Duration::from_seconds(info->scan_duration_s);
    const Pose2 moved = odometry_.motion_during(scan.utime, length).value_or(Pose2{});
    to_robot_frame(scan, *info, moved, options_.range_sigma_m, scan_in_robot_);
    LineSlamJournal journal;
    update = mapper_.process(scan_in_robot_, scan.utime, motion,
                             held_out ? MapUse::pose_only : MapUse::draw,
                             journal_.is_open() ? &journal : nullptr);
    if (journal_.is_open() && update.looked) journal_ << journal_line(scan.utime, journal) << '\n';
    ++scans_used_;
    if (!motion) ++scans_guessed_;
  }
  odom_at_last_scan_ = odom_from_robot;
  last_scan_ = scan.utime;
  if (odom_from_robot) odometry_at_scans_.push_back({scan.utime, *odom_from_robot});
  if (keep_scans_) keep(scan.utime, !is_tilted, held_out, update);
  publish_pose(scan.utime, update, is_tilted);
  after_scan(scan.utime);
}

void LineLcmAdapter::keep(Utime utime, bool level, bool held_out, const LineSlamUpdate& update) {
  UsedScan used;
  used.level = level;
  used.held_out = held_out;
  used.matched = level && update.matched > 0;
  used.prepared.utime = utime;
  if (level) {
    used.prepared.hits_in_robot = hits_of(scan_in_robot_);
    used.prepared.sensor_in_robot = scan_in_robot_.sensor_m;
    used.prepared.beams = static_cast<int>(scan_in_robot_.beams.size());
    used.prepared.no_return =
        used.prepared.beams - static_cast<int>(used.prepared.hits_in_robot.cols());
  }
  scans_.push_back(std::move(used));
}

void LineLcmAdapter::publish_pose(Utime utime, const LineSlamUpdate& update, bool is_carried) {
  live_.push_back({utime, update.world_from_robot});
  slam_pose_t message{};
  message.utime = utime.us;
  message.x_m = update.world_from_robot.x_m;
  message.y_m = update.world_from_robot.y_m;
  message.theta_rad = update.world_from_robot.theta_rad;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) message.covariance[i][j] = update.covariance(i, j);
  }
  // Walls just added are matched by definition: the first scan has a pose, too.
  const bool is_matched = !is_carried && (update.matched > 0 || live_.size() == 1);
  message.status = is_matched ? slam_pose_t::STATUS_MATCHED : slam_pose_t::STATUS_CARRIED;
  message.overlap = update.overlap;
  bus_.publish(channels::kSlamPose, message);
  if (update.trajectory_changed) publish_trajectory(utime);
}

void LineLcmAdapter::publish_map() {
  if (!last_scan_) return;
  bus_.publish(channels::kLineMap, to_message(mapper_.plan(), *last_scan_, ++map_revision_));
  map_sent_ = *last_scan_;
}

void LineLcmAdapter::publish_trajectory(Utime utime) {
  bus_.publish(channels::kTrajectory,
               marco::to_message(mapper_.key_trajectory(), utime, mapper_.revision()));
}

void LineLcmAdapter::after_scan(Utime utime) {
  if (is_after(utime, map_sent_, options_.map_every_s)) publish_map();
  if (!options_.checkpoint_path.empty() &&
      is_after(utime, checkpoint_saved_, options_.checkpoint_every_s)) {
    try_to_save(options_.checkpoint_path);
    checkpoint_saved_ = utime;
  }
}

void LineLcmAdapter::start_session() {
  hear_lasers_anew();
  take_waiting(Patience::is_over);
  odometry_.clear();
  pantilt_.clear();
  sensors_.clear();
  odom_at_last_scan_.reset();
}

void LineLcmAdapter::finish() {
  hear_lasers_anew();
  take_waiting(Patience::is_over);
  orders_.wait();
  if (!last_scan_) return;
  mapper_.finish();
  publish_map();
  publish_trajectory(*last_scan_);
  if (!options_.checkpoint_path.empty()) save_checkpoint(options_.checkpoint_path, checkpoint());
  if (journal_.is_open()) journal_.flush();
}

}  // namespace marco::slam
