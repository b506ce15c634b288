#include "simulator/live/live_robot.hpp"

#include <algorithm>
#include <cmath>

#include "common/samples.hpp"
#include "simulator/devices/bno055/emulator.hpp"
#include "simulator/devices/create/emulator.hpp"
#include "simulator/devices/hcs12/base_emulator.hpp"
#include "simulator/devices/kobuki/emulator.hpp"
#include "simulator/devices/p2os/emulator.hpp"
#include "simulator/devices/textbase/emulator.hpp"
#include "simulator/live/faulty_emulator.hpp"

namespace marco::sim {
namespace {

constexpr int64_t kKeepUs = 1'000'000;

constexpr double kWrongTiltDeg = 2.0;  // of the fault `wrong`

double angle_rad(const drivers::hcs12::PanTiltAxisOptions& axis, double units) {
  return deg_to_rad(axis.home_deg + units * axis.deg_per_unit);
}

using drivers::hcs12::BaseEmulator;
using drivers::hcs12::PanTiltEmulator;

constexpr double kClicksPerWheelTurn = 65500.0;
constexpr double kTicksPerWheelTurn = 1440.0;  // of a home-made base

// Faults of the kind `wrong`.
constexpr double kWrongWheel = 1.1, kWrongRateDegPerS = 3.0;

}  // namespace

void MotionHistory::add(const Moment& moment) {
  if (!moments_.empty() && moment.when <= moments_.back().when) return;
  moments_.push_back(moment);
  while (moments_.front().when < moment.when - Duration::from_us(kKeepUs)) moments_.pop_front();
}

MotionHistory::Moment MotionHistory::at(Utime when) const {
  if (moments_.empty()) return {};
  const auto after = std::lower_bound(moments_.begin(), moments_.end(), when,
                                      [](const Moment& m, Utime t) { return m.when < t; });
  if (after == moments_.begin()) return moments_.front();
  if (after == moments_.end()) return moments_.back();
  const Moment& a = *(after - 1);
  const Moment& b = *after;
  const double part = (when - a.when).seconds() / (b.when - a.when).seconds();
  return {when, interpolate(a.world_from_robot, b.world_from_robot, part),
          a.pan_rad + part * (b.pan_rad - a.pan_rad),
          a.tilt_rad + part * (b.tilt_rad - a.tilt_rad)};
}

drivers::hcs12::PanTiltEmulatorOptions LivePanTilt::board_options(const LivePanTiltSpec& spec) {
  drivers::hcs12::PanTiltEmulatorOptions options;
  options.listing_status = options.listing_stop = !spec.manual_firmware;
  options.pan_limit_units = spec.pan.limit_units;
  options.tilt_limit_units = spec.tilt.limit_units;
  return options;
}

void LivePanTilt::look(MotionHistory::Moment& moment) {
  if (!faults_.has("pantilt", FaultKind::stuck, moment.when)) {
    last_pan_rad_ = angle_rad(spec_.pan, board_.pan_units());
    last_tilt_rad_ = angle_rad(spec_.tilt, board_.tilt_units());
    if (faults_.has("pantilt", FaultKind::wrong, moment.when)) {
      last_tilt_rad_ += deg_to_rad(kWrongTiltDeg);
    }
  }
  moment.pan_rad = last_pan_rad_;
  moment.tilt_rad = last_tilt_rad_;
}

LiveRobot::LiveRobot(const RayCaster& rays,
                     const RobotSpec& spec,
                     const Pose2& start,
                     uint64_t seed)
    : rays_(rays), spec_(spec), floor_(rays, spec.body, spec.wheels, start, seed) {
  validate(spec, "robot");
  add_base();
  if (spec.pantilt.fitted) add_pantilt();
  for (const LiveLaserSpec& laser : spec.lasers) add_laser(laser, ++seed);
  if (spec.imu) add_imu();
}

void LiveRobot::add_device(const std::string& port,
                           std::unique_ptr<drivers::Emulator> emulator,
                           int tcp_port) {
  faults_.add_device(port);
  emulators_.push_back(std::move(emulator));
  emulators_.push_back(std::make_unique<FaultyEmulator>(*emulators_.back(), faults_, port));
  devices_.push_back({port, emulators_.back().get(), tcp_port});
}

void LiveRobot::add_base() {
  if (spec_.base == "hcs12") return add_hcs12();
  if (spec_.base == "text") return add_text();
  if (spec_.base == "create") return add_create();
  if (spec_.base == "kobuki") return add_kobuki();
  require(spec_.base == "p2os",
          "base '" + spec_.base + "': expected hcs12, p2os, text, create or kobuki");
  add_p2os();
}

void LiveRobot::add_p2os() {
  drivers::p2os::P2osWorld world;
  world.sonar_range_m = [this](const Pose2& sonar) { return sonar_range_m(sonar); };
  world.touch = [this] {
    const Contact& contact = floor_.contact();
    drivers::p2os::Touch touch;
    touch.stalled = contact.blocked;
    // Five bumpers an end, 30 degrees apart, from left to right as seen from within.
    const double ahead = contact.front ? contact.bearing_rad
                                       : normalize_angle(contact.bearing_rad + std::numbers::pi);
    const long place = std::clamp(std::lround((60.0 - rad_to_deg(ahead)) / 30.0), 0L, 4L);
    const auto bit = static_cast<uint8_t>(1U << place);
    if (contact.front) touch.front = bit;
    if (contact.rear) touch.rear = bit;
    return touch;
  };
  drivers::p2os::P2osEmulatorOptions options;
  options.track_m = spec_.track_m;
  require(drivers::p2os::model_of(spec_.pioneer).has_value(),
          "pioneer '" + spec_.pioneer + "' is not a known Pioneer subtype");
  options.name.subtype = spec_.pioneer;
  auto robot = std::make_unique<drivers::p2os::P2osEmulator>(world, options);
  wheels_.left_m = [base = robot.get()] { return base->left_m(); };
  wheels_.right_m = [base = robot.get()] { return base->right_m(); };
  add_device("base", std::move(robot));
}

void LiveRobot::add_hcs12() {
  drivers::hcs12::BaseWorld world;
  world.sonar_range_m = [this](std::size_t transducer) {
    const double bearing = static_cast<double>(transducer) * 2.0 * std::numbers::pi / 16.0;
    return sonar_range_m({spec_.sonar_ring_radius_m * std::cos(bearing),
                          spec_.sonar_ring_radius_m * std::sin(bearing), bearing});
  };
  drivers::hcs12::BaseEmulatorOptions options;
  options.sonar_form = spec_.manual_sonar ? drivers::hcs12::SonarForm::one_line
                                          : drivers::hcs12::SonarForm::line_each;
  auto board = std::make_unique<BaseEmulator>(world, options);
  const double click_m = std::numbers::pi * spec_.wheel_diameter_m / kClicksPerWheelTurn;
  wheels_.left_m = [base = board.get(), click_m] { return base->left_clicks() * click_m; };
  wheels_.right_m = [base = board.get(), click_m] { return base->right_clicks() * click_m; };
  add_device("base", std::move(board));
}

void LiveRobot::add_text() {
  namespace textbase = drivers::textbase;
  auto board = std::make_unique<textbase::TextBoard>(textbase::TextBoardOptions{}, [this] {
    const Contact& contact = floor_.contact();
    if (!contact.front) return 0U;
    return contact.bearing_rad >= 0.0 ? textbase::kLeftBumper : textbase::kRightBumper;
  });
  const double tick_m = std::numbers::pi * spec_.wheel_diameter_m / kTicksPerWheelTurn;
  wheels_.left_m = [base = board.get(), tick_m] { return base->left_ticks() * tick_m; };
  wheels_.right_m = [base = board.get(), tick_m] { return base->right_ticks() * tick_m; };
  add_device("base", std::move(board));
}

// Wheels and track are the maker's.
void LiveRobot::add_create() {
  namespace create = drivers::create;
  auto robot = std::make_unique<create::CreateEmulator>(create::CreateEmulatorOptions{}, [this] {
    create::CreateWorld world;
    const Contact& contact = floor_.contact();
    world.left_bump = contact.front && contact.bearing_rad >= 0.0;
    world.right_bump = contact.front && contact.bearing_rad < 0.0;
    return world;
  });
  wheels_.left_m = [base = robot.get()] { return base->left_m(); };
  wheels_.right_m = [base = robot.get()] { return base->right_m(); };
  add_device("base", std::move(robot));
}

// The same.
void LiveRobot::add_kobuki() {
  namespace kobuki = drivers::kobuki;
  auto robot = std::make_unique<kobuki::KobukiEmulator>(kobuki::KobukiEmulatorOptions{}, [this] {
    constexpr double kCentreRad = 0.5;
    kobuki::KobukiWorld world;
    const Contact& contact = floor_.contact();
    if (!contact.front) return world;
    const bool centre = std::abs(contact.bearing_rad) < kCentreRad;
    world.bumpers = centre                       ? kobuki::kCentre
                    : contact.bearing_rad >= 0.0 ? kobuki::kLeft
                                                 : kobuki::kRight;
    return world;
  });
  wheels_.left_m = [base = robot.get()] { return base->left_m(); };
  wheels_.right_m = [base = robot.get()] { return base->right_m(); };
  add_device("base", std::move(robot));
}

void LiveRobot::add_pantilt() {
  auto board = std::make_unique<PanTiltEmulator>(LivePanTilt::board_options(spec_.pantilt));
  pantilt_.emplace(spec_.pantilt, *board, faults_);
  add_device("pantilt", std::move(board));
}

void LiveRobot::add_laser(const LiveLaserSpec& spec, uint64_t seed) {
  require(spec.mount == "robot" || (spec.mount == "pantilt" && spec_.pantilt.fitted),
          "lasers.mount '" + spec.mount + "': expected robot, or pantilt where there is one");
  const Eigen::Vector3d turn = three(spec.roll_pitch_yaw_deg, "lasers.roll_pitch_yaw_deg");
  SensorInfo info;
  info.mount = spec.mount == "robot" ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
  info.parent_from_sensor =
      make_pose3(three(spec.position_m, "lasers.position_m"), deg_to_rad(turn.x()),
                 deg_to_rad(turn.y()), deg_to_rad(turn.z()));
  lasers_.push_back(std::make_unique<LiveLaser>(
      rays_, spec, [this, info](Utime when) { return world_from_laser(info, when); }, faults_,
      seed));
  const auto world = [laser = lasers_.back().get()](const drivers::LaserSweep& sweep) {
    return laser->sweep(sweep);
  };
  add_device(spec.port, laser_emulator(spec, world), spec.tcp_port);
}

drivers::imu::Motion LiveRobot::motion_felt(Utime when) {
  constexpr double kOverS = 0.04;
  const Duration half = Duration::from_seconds(kOverS / 2.0);
  const Pose2 step =
      between(history_.at(when - half).world_from_robot, history_.at(when + half).world_from_robot);
  drivers::imu::Motion felt;
  felt.rates_rad_per_s.z() = step.theta_rad / kOverS;
  if (faults_.has("imu", FaultKind::wrong, when)) {
    felt.rates_rad_per_s.z() += deg_to_rad(kWrongRateDegPerS);
  }
  if (!faults_.has("imu", FaultKind::stuck, when)) last_felt_ = felt;
  return last_felt_;
}

void LiveRobot::add_imu() {
  const auto motion = [this](Utime when) { return motion_felt(when); };
  if (spec_.imu_device == "bno055") {
    return add_device("imu", std::make_unique<drivers::bno055::Bno055Emulator>(motion));
  }
  require(spec_.imu_device == "witmotion",
          "imu_device '" + spec_.imu_device + "': expected witmotion or bno055");
  add_device("imu", std::make_unique<drivers::imu::ImuEmulator>(motion));
}

void LiveRobot::update(Utime now) {
  if (now <= now_) return;
  now_ = now;
  const double left_m = wheels_.left_m(), right_m = wheels_.right_m();
  const double left_scale = faults_.has("base", FaultKind::wrong, now) ? kWrongWheel : 1.0;
  if (!faults_.has("base", FaultKind::stuck, now)) {
    floor_.roll((left_m - wheels_.last_left_m) * left_scale, right_m - wheels_.last_right_m,
                spec_.track_m);
  }
  wheels_.last_left_m = left_m;
  wheels_.last_right_m = right_m;
  MotionHistory::Moment moment{now, floor_.world_from_robot(), 0.0, 0.0};
  if (pantilt_) pantilt_->look(moment);
  history_.add(moment);
}

Pose3 LiveRobot::world_from_laser(const SensorInfo& laser, Utime when) const {
  const MotionHistory::Moment moment = history_.at(when);
  const Pose3 world_from_robot = lift(moment.world_from_robot);
  if (laser.mount == SensorInfo::Mount::robot) return world_from_robot * laser.parent_from_sensor;
  SensorInfo base;
  base.parent_from_sensor = make_pose3(three(spec_.pantilt.position_m, "pantilt.position_m"));
  base.tilt_axis_m = three(spec_.pantilt.tilt_axis_m, "pantilt.tilt_axis_m");
  return world_from_robot * robot_from_pantilt_sensor(base, laser, moment.pan_rad, moment.tilt_rad);
}

double LiveRobot::sonar_range_m(const Pose2& robot_from_sonar) const {
  // The nearest thing in the cone that does not mirror the sound away.
  constexpr double kHalfConeDeg = 7.5, kMirrorsBeyondDeg = 40.0, kMaxM = 12.2;
  const Pose2 world_from_sonar = floor_.world_from_robot() * robot_from_sonar;
  const Eigen::Vector3f origin(static_cast<float>(world_from_sonar.x_m),
                               static_cast<float>(world_from_sonar.y_m),
                               static_cast<float>(spec_.sonar_height_m));
  double nearest = HUGE_VAL;
  for (const double part : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const double bearing = world_from_sonar.theta_rad + part * deg_to_rad(kHalfConeDeg);
    const Eigen::Vector3f direction(static_cast<float>(std::cos(bearing)),
                                    static_cast<float>(std::sin(bearing)), 0.0F);
    const auto hit = rays_.cast(origin, direction, static_cast<float>(kMaxM));
    if (!hit) continue;
    const auto cosine = static_cast<double>(-hit->normal.dot(direction));
    if (cosine < std::cos(deg_to_rad(kMirrorsBeyondDeg))) continue;
    nearest = std::min(nearest, static_cast<double>(hit->range_m));
  }
  return nearest;
}

}  // namespace marco::sim
