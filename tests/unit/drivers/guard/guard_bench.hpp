#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "common/pose3.hpp"
#include "guard_world.hpp"
#include "plain_base.hpp"

namespace marco::drivers::testing {

struct BenchLaser {
  double view_deg = 360.0;
  int beams = 241;
  double hz = 10.0;
  double height_m = 0.3;
  double noise_m = 0.0;
  double range_max_m = 80.0;
  bool runs = true;
};

/// The body met something.
struct Touch {
  bool was_seen = false;       ///< the place, within 3 cm and in the last 30 s
  double speed_m_per_s = 0.0;  ///< of the body's fastest point
};

/// A plain base with a laser in a world, in simulated time. Set what is public, then start().
class GuardBench {
 public:
  /// All outlive it.
  GuardBench(const GuardWorld& world, const GuardOptions& options, std::mt19937& random)
      : world_(world), options_(options), body_(options.body_m), random_(random) {}

  void start(const Pose2& at) {
    base_ = std::make_unique<PlainBase>(options_, delay_s);
    base_->world_from_robot = at;
    advance();
    tell_mount();
    base_->on_connection(true, now_);
  }
  /// The laser's SENSOR_INFO, or another one.
  void tell_mount() {
    SensorInfo info;
    info.parent_from_sensor.translation().z() = laser.height_m;
    info.range_max_m = laser.range_max_m;
    base_->guard().on_sensor_info(info);
  }

  /// A scan, when it is time for one.
  void look() {
    if (!laser.runs || now_ < next_scan_) return;
    next_scan_ = now_ + Duration::from_seconds(1.0 / laser.hz - 1e-4);
    scanned_.clear();
    LaserScan scan;
    scan.utime = now_;
    const double view_rad = deg_to_rad(laser.view_deg);
    scan.first_bearing_rad = -view_rad / 2.0;
    scan.bearing_step_rad = view_rad / (laser.beams - 1);
    const Pose2& pose = base_->world_from_robot;
    std::normal_distribution<double> noise(0.0, 1.0);
    for (int i = 0; i < laser.beams; ++i) {
      const double bearing = pose.theta_rad + scan.first_bearing_rad + i * scan.bearing_step_rad;
      double range_m = world_.range_m(pose.translation_m(), bearing);
      if (laser.noise_m > 0.0) range_m += laser.noise_m * noise(random_);
      scan.ranges_m.push_back(static_cast<float>(range_m));
      if (range_m > laser.range_max_m) continue;
      scanned_.push_back(pose.translation_m() +
                         range_m * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)));
      if (range_m < 1.0) seen_.push_back({now_, scanned_.back()});
    }
    while (!seen_.empty() && (now_ - seen_.front().when).seconds() > 29.0) seen_.pop_front();
    base_->guard().on_scan(scan, pose, now_);
  }
  /// A control step, with an order or without.
  void step(const std::optional<BaseVelocity>& order = {}) {
    if (order) give(*order);
    advance();
    roll();
  }
  void run(double seconds, const std::optional<BaseVelocity>& order = {}) {
    for (const Utime end = now_ + Duration::from_seconds(seconds); now_ < end;) {
      look();
      step(order);
    }
  }
  void give(const BaseVelocity& order) {
    BaseCommand command;
    command.kind = BaseCommand::Kind::velocity;
    command.velocity_m_per_s = order.ahead_m_per_s;
    command.yaw_rate_rad_per_s = order.turn_rad_per_s;
    give(command);
  }
  void give(BaseCommand command) {
    command.utime = now_;
    command.id = ++id_;
    base_->command(command, now_);
  }

  PlainBase& base() { return *base_; }
  const PlainBase& base() const { return *base_; }
  const GuardWorld& world() const { return world_; }
  const Footprint& body() const { return body_; }
  const std::vector<Eigen::Vector2d>& scanned() const { return scanned_; }  ///< world frame
  const std::optional<Touch>& touched() const { return touched_; }
  Utime now() const { return now_; }
  std::string note() const { return base_->status().note; }

  BenchLaser laser;
  double delay_s = 0.1;  ///< of the wheels
  double step_s = 0.02;  ///< of the control

 private:
  struct Seen {
    Utime when;
    Eigen::Vector2d point;
  };
  void advance() {
    std::vector<uint8_t> nowhere;
    base_->advance(now_, nowhere);
    base_->take_output();
  }
  void roll() {
    constexpr int kParts = 4;
    for (int i = 0; i < kParts; ++i) {
      now_ = now_ + Duration::from_seconds(step_s / kParts);
      base_->roll(step_s / kParts, now_);
      const GuardWorld::Gap gap = world_.gap(body_, base_->world_from_robot);
      if (gap.gap_m > 0.0 || touched_) continue;
      const bool seen = std::any_of(seen_.begin(), seen_.end(), [&](const Seen& one) {
        return (one.point - gap.at).norm() < 0.03;
      });
      touched_ = Touch{seen, base_->velocity().fastest_m_per_s(body_.radius_m())};
    }
  }

  const GuardWorld& world_;
  GuardOptions options_;
  Footprint body_;
  std::mt19937& random_;
  std::unique_ptr<PlainBase> base_;
  std::deque<Seen> seen_;
  std::vector<Eigen::Vector2d> scanned_;
  std::optional<Touch> touched_;
  Utime now_ = Utime::from_seconds(1000.0), next_scan_;
  int64_t id_ = 0;
};

}  // namespace marco::drivers::testing
