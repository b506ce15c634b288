#include "simulator/live/live_robot.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/samples.hpp"
#include "drivers/hokuyo/emulator.hpp"
#include "drivers/imu/emulator.hpp"
#include "drivers/leuze/emulator.hpp"
#include "drivers/p2os/emulator.hpp"
#include "drivers/rplidar/emulator.hpp"
#include "drivers/sick/emulator.hpp"

namespace marco::sim {
namespace {

using drivers::hcs12::BaseEmulator;
using drivers::hcs12::PanTiltEmulator;

constexpr double kClicksPerWheelTurn = 65500.0;

// Faults of the kind `wrong`.
constexpr double kWrongRangeM = 0.2, kWrongWheel = 1.1, kWrongTiltDeg = 2.0,
                 kWrongRateDegPerS = 3.0;

}  // namespace

struct LiveRobot::Laser {
  LiveLaserSpec spec;
  SensorInfo info;
  std::map<double, std::vector<double>> last_answers;  ///< by first bearing: turns interlace
};

LiveRobot::~LiveRobot() = default;

LiveRobot::LiveRobot(const RayCaster& rays,
                     const RobotSpec& spec,
                     const Pose2& start,
                     uint64_t seed)
    : rays_(rays),
      spec_(spec),
      floor_(rays, spec.body, spec.wheels, start, seed),
      random_(seed + 1) {
  validate(spec, "robot");
  add_base();
  if (spec.pantilt.fitted) add_pantilt();
  for (const LiveLaserSpec& laser : spec.lasers) add_laser(laser);
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
  require(spec_.base == "p2os", "base '" + spec_.base + "': expected hcs12 or p2os");
  add_p2os();
}

void LiveRobot::add_p2os() {
  drivers::p2os::P2osWorld world;
  world.sonar_range_m = [this](std::size_t sonar) {
    return sonar_range_m(drivers::p2os::p2dx_sonars()[sonar]);
  };
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
  auto robot = std::make_unique<drivers::p2os::P2osEmulator>(world, options);
  left_m_ = [base = robot.get()] { return base->left_m(); };
  right_m_ = [base = robot.get()] { return base->right_m(); };
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
  left_m_ = [base = board.get(), click_m] { return base->left_clicks() * click_m; };
  right_m_ = [base = board.get(), click_m] { return base->right_clicks() * click_m; };
  add_device("base", std::move(board));
}

void LiveRobot::add_pantilt() {
  drivers::hcs12::PanTiltEmulatorOptions options;
  options.listing_status = options.listing_stop = !spec_.pantilt.manual_firmware;
  options.pan_limit_units = spec_.pantilt.pan.limit_units;
  options.tilt_limit_units = spec_.pantilt.tilt.limit_units;
  auto board = std::make_unique<PanTiltEmulator>(options);
  pantilt_ = board.get();
  add_device("pantilt", std::move(board));
}

void LiveRobot::add_laser(const LiveLaserSpec& spec) {
  require(spec.mount == "robot" || (spec.mount == "pantilt" && spec_.pantilt.fitted),
          "lasers.mount '" + spec.mount + "': expected robot, or pantilt where there is one");
  const Eigen::Vector3d turn = three(spec.roll_pitch_yaw_deg, "lasers.roll_pitch_yaw_deg");
  auto laser = std::make_unique<Laser>();
  laser->spec = spec;
  laser->info.mount = spec.mount == "robot" ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
  laser->info.parent_from_sensor =
      make_pose3(three(spec.position_m, "lasers.position_m"), deg_to_rad(turn.x()),
                 deg_to_rad(turn.y()), deg_to_rad(turn.z()));
  const drivers::LaserWorld world = [this, seen_by = laser.get()](const drivers::LaserSweep& s) {
    return sweep(*seen_by, s);
  };
  add_device(spec.port, laser_emulator(spec, world), spec.tcp_port);
  lasers_.push_back(std::move(laser));
}

std::unique_ptr<drivers::Emulator> LiveRobot::laser_emulator(
    const LiveLaserSpec& spec, const drivers::LaserWorld& world) const {
  const auto own = [&spec](int baud) { return spec.baud > 0 ? spec.baud : baud; };
  if (spec.device == "sick") {
    drivers::sick::SickEmulatorOptions options;
    options.baud = own(options.baud);
    options.power_on_s = 1.0;
    return std::make_unique<drivers::sick::SickEmulator>(world, options);
  }
  if (spec.device == "hokuyo") {
    return std::make_unique<drivers::hokuyo::HokuyoEmulator>(
        world, drivers::hokuyo::HokuyoEmulatorOptions{});
  }
  if (spec.device == "rplidar") {
    drivers::rplidar::RplidarEmulatorOptions options;
    options.baud = own(options.baud);
    return std::make_unique<drivers::rplidar::RplidarEmulator>(world, options);
  }
  // The Rotoscan of thesis A, out of its calibration as it was.
  if (spec.device == "leuze_service") {
    return std::make_unique<drivers::leuze::LeuzeServiceEmulator>(
        world, drivers::leuze::thesis_a_geometry());
  }
  require(spec.device == "leuze", "lasers.device '" + spec.device +
                                      "': expected sick, leuze, leuze_service, hokuyo or rplidar");
  drivers::leuze::LeuzeEmulatorOptions options;
  options.baud = spec.tcp_port >= 0 ? 0 : own(options.baud);
  options.geometry.scale = drivers::leuze::thesis_a_geometry().scale;
  return std::make_unique<drivers::leuze::LeuzeEmulator>(world, options);
}

void LiveRobot::add_imu() {
  const auto motion = [this](Utime when) {
    constexpr double kOverS = 0.04;
    const Duration half = Duration::from_seconds(kOverS / 2.0);
    drivers::imu::Motion felt;
    const Pose2 step = between(history_.at(when - half).world_from_robot,
                               history_.at(when + half).world_from_robot);
    felt.rates_rad_per_s.z() = step.theta_rad / kOverS;
    if (faults_.has("imu", FaultKind::wrong, when)) {
      felt.rates_rad_per_s.z() += deg_to_rad(kWrongRateDegPerS);
    }
    if (!faults_.has("imu", FaultKind::stuck, when)) last_felt_ = felt;
    return last_felt_;
  };
  add_device("imu", std::make_unique<drivers::imu::ImuEmulator>(motion));
}

void LiveRobot::update(Utime now) {
  if (now <= now_) return;
  now_ = now;
  const double left = left_m_(), right = right_m_();
  const double left_part = faults_.has("base", FaultKind::wrong, now) ? kWrongWheel : 1.0;
  if (!faults_.has("base", FaultKind::stuck, now)) {
    floor_.roll((left - left_rolled_m_) * left_part, right - right_rolled_m_, spec_.track_m);
  }
  left_rolled_m_ = left;
  right_rolled_m_ = right;
  MotionHistory::Moment moment{now, floor_.world_from_robot(), 0.0, 0.0};
  if (pantilt_ != nullptr) {
    const auto angle = [](const drivers::hcs12::PanTiltAxisOptions& axis, double units) {
      return deg_to_rad(axis.home_deg + units * axis.deg_per_unit);
    };
    moment.pan_rad = angle(spec_.pantilt.pan, pantilt_->pan_units());
    moment.tilt_rad = angle(spec_.pantilt.tilt, pantilt_->tilt_units());
    if (faults_.has("pantilt", FaultKind::wrong, now)) {
      moment.tilt_rad += deg_to_rad(kWrongTiltDeg);
    }
    if (faults_.has("pantilt", FaultKind::stuck, now)) {
      moment.pan_rad = stuck_pan_rad_;
      moment.tilt_rad = stuck_tilt_rad_;
    }
    stuck_pan_rad_ = moment.pan_rad;
    stuck_tilt_rad_ = moment.tilt_rad;
  }
  history_.add(moment);
}

Pose3 LiveRobot::world_from_laser(const Laser& laser, Utime when) const {
  const MotionHistory::Moment moment = history_.at(when);
  const Pose3 world_from_robot = lift(moment.world_from_robot);
  if (laser.info.mount == SensorInfo::Mount::robot) {
    return world_from_robot * laser.info.parent_from_sensor;
  }
  SensorInfo base;
  base.parent_from_sensor = make_pose3(three(spec_.pantilt.position_m, "pantilt.position_m"));
  base.tilt_axis_m = three(spec_.pantilt.tilt_axis_m, "pantilt.tilt_axis_m");
  return world_from_robot *
         robot_from_pantilt_sensor(base, laser.info, moment.pan_rad, moment.tilt_rad);
}

std::vector<double> LiveRobot::sweep(Laser& laser, const drivers::LaserSweep& sweep) {
  // The model sweeps counter-clockwise; a clockwise one is that, told backwards.
  const bool clockwise = sweep.bearing_step_rad < 0.0;
  const double last_s = sweep.beam_interval_s * (sweep.beams - 1);
  LaserOptions optics = laser.spec.optics;
  optics.beams = sweep.beams;
  optics.step_deg = rad_to_deg(std::abs(sweep.bearing_step_rad));
  optics.first_bearing_deg =
      rad_to_deg(sweep.first_bearing_rad) - (clockwise ? optics.step_deg * (sweep.beams - 1) : 0.0);
  optics.scan_duration_s = last_s;
  optics.quantum_m = 0.0;  // the device rounds
  const LaserModel model(rays_, optics);
  const std::vector<float> ranges_m = model.scan(
      [&](double after_s) {
        const double offset_s = clockwise ? last_s - after_s : after_s;
        return world_from_laser(laser, sweep.first_beam + Duration::from_seconds(offset_s));
      },
      random_);
  std::vector<double> answer(ranges_m.begin(), ranges_m.end());
  for (double& range_m : answer) {
    if (range_m >= optics.range_max_m) range_m = HUGE_VAL;
  }
  if (clockwise) std::reverse(answer.begin(), answer.end());
  if (faults_.has(laser.spec.port, FaultKind::wrong, sweep.first_beam)) {
    for (double& range_m : answer) range_m += kWrongRangeM;
  }
  std::vector<double>& last = laser.last_answers[sweep.first_bearing_rad];
  const bool is_stuck = faults_.has(laser.spec.port, FaultKind::stuck, sweep.first_beam);
  if (!is_stuck || last.size() != answer.size()) last = answer;
  return last;
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
