#include "slam/process/lcm_adapter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/slam_pose_t.hpp"
#include "slam/input/odometry_restart.hpp"

namespace marco::slam {
namespace {

constexpr int kDrawnAtOnce = 4;  // keyframes

slam_pose_t to_message(Utime utime, const SlamUpdate& update) {
  slam_pose_t message;
  message.utime = utime.us;
  message.x_m = update.world_from_robot.x_m;
  message.y_m = update.world_from_robot.y_m;
  message.theta_rad = update.world_from_robot.theta_rad;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      message.covariance[row][column] = update.covariance(row, column);
    }
  }
  message.status = slam_pose_t::STATUS_CARRIED;
  if (update.status == SlamUpdate::Status::matched) message.status = slam_pose_t::STATUS_MATCHED;
  if (update.status == SlamUpdate::Status::lost) message.status = slam_pose_t::STATUS_LOST;
  message.overlap = update.overlap;
  return message;
}

}  // namespace

SlamAdapter::SlamAdapter(process::Bus& bus,
                         const SlamAdapterOptions& options,
                         std::function<void(const std::string&)> warn)
    : bus_(bus),
      options_(options),
      drops_(warn),
      session_(options.slam, options.localizer),
      grid_(options.slam.grid) {
  validate(options, "slam_process");
  if (!options_.checkpoint_path.empty()) {
    if (auto state = load_adapter_state(options_.checkpoint_path, warn)) {
      restore(std::move(*state));
      resumed_ = true;
    }
  }
  subscribe();
}

void SlamAdapter::subscribe() {
  bus_.subscribe_raw(channels::kLidarPattern, [this](const process::RawMessage& raw) {
    drops_.count_received();
    try {
      const auto sample = decode_sample(std::string(raw.channel), raw.bytes);
      if (!sample) {
        drops_.count("undecodable");
        return;
      }
      on_scan(std::get<LaserScan>(*sample));
    } catch (const std::invalid_argument& bad_message) {
      drops_.count(bad_message.what());
    }
  });
  bus_.subscribe<sensor_info_t>(channels::kSensorInfo, drops_, [this](const auto& message, auto&) {
    require(note_sensor(sensors_, from_message(message)), kTooManySensors);
  });
  bus_.subscribe<odometry_t>(channels::kOdometry, drops_, [this](const auto& message, auto&) {
    const OdometrySample sample = from_message(message);
    if (odometry_began_anew(motion_.odometry, sample)) {
      drops_.count("odometry began anew: none for a scan");
      motion_.odometry.clear();
      odometry_is_parted_ = true;
    }
    motion_.odometry.add(sample.utime, sample.odom_from_robot);
    use_waiting_scans();
  });
  bus_.subscribe<imu_t>(channels::kImu, drops_,
                        [this](const auto& message, auto&) { on_imu(from_message(message)); });
  bus_.subscribe<pantilt_state_t>(
      channels::kPanTiltState, drops_, [this](const auto& message, auto&) {
        const PanTiltState state = from_message(message);
        motion_.pantilt.add(state.utime, {state.pan_rad, state.tilt_rad, 0.0});
        use_waiting_scans();
      });
  bus_.subscribe<map_request_t>(channels::kMapRequest, drops_, [this](const auto& request, auto&) {
    const bool all = request.channel.empty();
    if (all || request.channel == channels::kTrajectory) publish_trajectory(newest_scan_);
    if (all || request.channel == channels::kGridMap) publish_grid(newest_scan_);
  });
  bus_.subscribe<slam_command_t>(
      channels::kSlamCommand, drops_, [this](const auto& command, auto&) {
        orders_.take(command, options_.maps_folder,
                     [this](const SlamOrder& order) { return obey(order); });
      });
}

void SlamAdapter::on_imu(const ImuSample& sample) {
  double heading_rad = 0.0;
  if (!motion_.gyro_heading.empty()) {
    const double dt_s = (sample.utime - motion_.gyro_heading.newest()).seconds();
    heading_rad = motion_.gyro_heading.newest_pose().theta_rad;
    constexpr double kMaxGapS = 0.5;
    if (dt_s < 0.0 || dt_s > kMaxGapS) {
      drops_.count("imu: gap in time");
      motion_.gyro_heading.clear();
    } else {
      heading_rad = normalize_angle(heading_rad + dt_s * sample.angular_velocity_rad_per_s.z());
    }
  }
  motion_.gyro_heading.add(sample.utime, {0.0, 0.0, heading_rad});
}

void SlamAdapter::on_scan(LaserScan scan) {
  if (paused_) {
    drops_.count("paused");
    return;
  }
  if (!sensors_.contains(scan.channel)) {
    drops_.count("no SENSOR_INFO for " + scan.channel + " yet");
    return;
  }
  if (const auto wrong = range_units_.look(scan)) return drops_.count(*wrong);
  if (!one_source_) {
    let_wait(std::move(scan));
    return;
  }
  OneSource& source = (*one_source_)[scan.channel];
  for (LaserScan& own : take_own(source, std::move(scan), drops_)) let_wait(std::move(own));
}

void SlamAdapter::let_wait(LaserScan scan) {
  newest_scan_ = scan.utime;
  waiting_.push_back(std::move(scan));
  use_waiting_scans();
}

bool SlamAdapter::ready(const LaserScan& scan) const {
  // Stamps of a bursty log step backwards by a second: then, too, waiting is of no use.
  const Duration waited = newest_scan_ - scan.utime;
  if (std::abs(waited.seconds()) > options_.patience_s) return true;
  // A source that has been silent for longer is not waited for any more.
  const Duration patience = Duration::from_seconds(options_.patience_s);
  const auto known = [&](const PoseBuffer& buffer) {
    return buffer.empty() || buffer.newest() >= scan.utime ||
           scan.utime - buffer.newest() > patience;
  };
  const bool on_pantilt = sensors_.at(scan.channel).mount == SensorInfo::Mount::pantilt;
  return known(motion_.odometry) && (!on_pantilt || known(motion_.pantilt));
}

void SlamAdapter::use_waiting_scans() {
  while (!waiting_.empty() && ready(waiting_.front())) {
    const LaserScan scan = std::move(waiting_.front());
    waiting_.pop_front();
    use(scan);
  }
}

void SlamAdapter::close_loops_in_background() {
  session_.defer_loop_work();
  if (!loop_worker_) loop_worker_ = std::make_unique<LoopWorker>();
  orders_.write_in_background();
  keep_short_path();
}

void SlamAdapter::keep_short_path() {
  session_.keep_short_path(options_.path_every_m);
  path_is_short_ = true;
  live_ = {};
  odometry_at_scans_ = {};
}

bool SlamAdapter::exchange_loop_work(Utime utime) {
  if (!loop_worker_) return false;
  bool changed = false;
  if (loop_worker_->busy()) {
    const Duration since = utime - loop_work_asked_;
    if (std::abs(since.seconds()) < options_.loop_delay_s) return false;
    const std::optional<LoopWork> done = loop_worker_->take_done();
    if (!done) {
      // Counted at once: a run may end before it comes.
      if (!std::exchange(loop_work_is_late_, true)) ++late_loop_work_;
      return false;
    }
    loop_work_is_late_ = false;
    changed = session_.accept(*done);
  }
  if (auto work = session_.take_loop_work()) {
    loop_worker_->start(std::move(*work));
    loop_work_asked_ = utime;
  }
  return changed;
}

void SlamAdapter::use(const LaserScan& scan) {
  SlamInput input = input_of(scan, sensors_.at(scan.channel));
  // One scan without any: what was counted before and after it is not compared.
  if (std::exchange(odometry_is_parted_, false)) input.motion.odom_from_robot.reset();
  ++scan_count_;
  input.may_draw = options_.hold_out_every == 0 || scan_count_ % options_.hold_out_every != 0;
  const bool loop_closed = exchange_loop_work(scan.utime);
  SlamUpdate update = session_.process(input);
  update.trajectory_changed = update.trajectory_changed || loop_closed;
  if (input.motion.odom_from_robot && !path_is_short_) {
    odometry_at_scans_.push_back({scan.utime, *input.motion.odom_from_robot});
  }
  if (keep_scans_) {
    if (input.may_draw) input.scan.hits_in_robot.resize(2, 0);
    scans_.push_back({std::move(input.scan), input.level, !input.may_draw,
                      update.status == SlamUpdate::Status::matched});
  }
  // In parts: drawing all keyframes anew takes seconds.
  if (loop_worker_ && options_.map_period_s > 0.0) grid_.advance(session_.keys(), kDrawnAtOnce);
  publish(scan, update);
  save_checkpoint_now_and_then(scan.utime);
}

void SlamAdapter::publish(const LaserScan& scan, const SlamUpdate& update) {
  if (!path_is_short_) live_.push_back({scan.utime, update.world_from_robot});
  bus_.publish(channels::kSlamPose, to_message(scan.utime, update));
  if (update.trajectory_changed) publish_trajectory(scan.utime);
  if (options_.map_period_s <= 0.0) return;
  const Duration since = scan.utime - last_grid_;
  if (std::abs(since.seconds()) < options_.map_period_s) return;
  last_grid_ = scan.utime;
  publish_trajectory(scan.utime);
  publish_grid(scan.utime);
}

void SlamAdapter::publish_trajectory(Utime utime) {
  bus_.publish(channels::kTrajectory,
               marco::to_message(session_.key_trajectory(), utime, session_.revision()));
}

void SlamAdapter::publish_grid(Utime utime) {
  const OccupancyGrid& grid = loop_worker_ ? grid_.grid() : grid_.update(session_.keys());
  note_size(grid);
  const GridMap map = grid.to_map();
  for (const grid_map_t& tile : to_messages(map, utime, session_.revision())) {
    bus_.publish(channels::kGridMap, tile);
  }
}

void SlamAdapter::note_size(const OccupancyGrid& grid) {
  if (!grid.too_large_m() || std::exchange(too_large_, true)) return;
  char text[120];
  std::snprintf(text, sizeof text, "the map would be %.0f x %.0f m: what is far off is not drawn",
                grid.too_large_m()->x(), grid.too_large_m()->y());
  drops_.count(text);
}

void SlamAdapter::use_all_waiting() {
  hear_lasers_anew();
  while (!waiting_.empty()) {
    const LaserScan scan = std::move(waiting_.front());
    waiting_.pop_front();
    use(scan);
  }
}

void SlamAdapter::start_session() {
  use_all_waiting();
  motion_ = MotionBuffers{};
  sensors_.clear();
  session_.start_session();
}

void SlamAdapter::finish() {
  use_all_waiting();
  if (loop_worker_) {
    if (const auto done = loop_worker_->wait()) session_.accept(*done);
  }
  loop_worker_.reset();
  session_.finish();
  orders_.wait();
  if (scan_count_ == 0) return;
  publish_trajectory(newest_scan_);
  publish_grid(newest_scan_);
}

}  // namespace marco::slam
