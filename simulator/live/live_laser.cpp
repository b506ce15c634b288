#include "simulator/live/live_laser.hpp"

#include <cmath>
#include <utility>

#include "drivers/hokuyo/emulator.hpp"
#include "drivers/ldlidar/emulator.hpp"
#include "drivers/leuze/service_emulator.hpp"
#include "drivers/rplidar/emulator.hpp"
#include "drivers/sick/emulator.hpp"
#include "drivers/ydlidar/emulator.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::sim {
namespace {

constexpr double kWrongRangeM = 0.2;  // of the fault `wrong`
constexpr double kSectorsPerDeg = 10.0;

}  // namespace

std::unique_ptr<drivers::Emulator> laser_emulator(const LiveLaserSpec& spec,
                                                  drivers::LaserWorld world) {
  const auto own = [&spec](int baud) { return spec.baud > 0 ? spec.baud : baud; };
  if (spec.device == "sick") {
    drivers::sick::SickEmulatorOptions options;
    options.baud = own(options.baud);
    options.power_on_s = 1.0;
    return std::make_unique<drivers::sick::SickEmulator>(std::move(world), options);
  }
  if (spec.device == "hokuyo") {
    return std::make_unique<drivers::hokuyo::HokuyoEmulator>(
        std::move(world), drivers::hokuyo::HokuyoEmulatorOptions{});
  }
  drivers::rplidar::RplidarEmulatorOptions a2;
  a2.model = 0x28;
  a2.turns_per_s = 10.0;
  for (const auto& [device, emulated] :
       {std::pair{"rplidar", drivers::rplidar::RplidarEmulatorOptions{}},
        std::pair{"rplidar_a2", a2}, std::pair{"rplidar_c1", drivers::rplidar::c1()},
        std::pair{"rplidar_s2", drivers::rplidar::s2()}}) {
    if (spec.device != device) continue;
    auto options = emulated;
    options.baud = own(options.baud);
    return std::make_unique<drivers::rplidar::RplidarEmulator>(std::move(world), options);
  }
  for (const auto& [device, emulated] :
       {std::pair{"ld19", drivers::ldlidar::LdlidarEmulatorOptions{}},
        std::pair{"stl27l", drivers::ldlidar::stl27l()}}) {
    if (spec.device != device) continue;
    auto options = emulated;
    options.baud = own(options.baud);
    return std::make_unique<drivers::ldlidar::LdlidarEmulator>(std::move(world), options);
  }
  for (const auto& [device, emulated] :
       {std::pair{"ydlidar_x2", drivers::ydlidar::x2()},
        std::pair{"ydlidar_x4", drivers::ydlidar::YdlidarEmulatorOptions{}},
        std::pair{"ydlidar_g4", drivers::ydlidar::g4()}}) {
    if (spec.device != device) continue;
    auto options = emulated;
    options.baud = own(options.baud);
    return std::make_unique<drivers::ydlidar::YdlidarEmulator>(std::move(world), options);
  }
  // The Rotoscan of thesis A, out of calibration as it was.
  if (spec.device == "leuze_service") {
    return std::make_unique<drivers::leuze::LeuzeServiceEmulator>(
        std::move(world), drivers::leuze::thesis_a_geometry());
  }
  require(
      spec.device == "leuze",
      "lasers.device '" + spec.device +
          "': expected sick, leuze, leuze_service, hokuyo, rplidar, "
          "rplidar_a2, rplidar_c1, rplidar_s2, ld19, stl27l, ydlidar_x2, ydlidar_x4 or ydlidar_g4");
  drivers::leuze::LeuzeEmulatorOptions options;
  options.baud = spec.tcp_port >= 0 ? 0 : own(options.baud);
  options.geometry.scale = drivers::leuze::thesis_a_geometry().scale;
  return std::make_unique<drivers::leuze::LeuzeEmulator>(std::move(world), options);
}

LiveLaser::LiveLaser(const RayCaster& rays,
                     const LiveLaserSpec& spec,
                     Trajectory world_from_sensor,
                     const FaultBoard& faults,
                     uint64_t seed)
    : rays_(rays),
      spec_(spec),
      world_from_sensor_(std::move(world_from_sensor)),
      faults_(faults),
      random_(seed) {}

std::vector<double> LiveLaser::sweep(const drivers::LaserSweep& sweep) {
  LaserOptions optics = spec_.optics;
  optics.beams = sweep.beams;
  optics.first_bearing_deg = rad_to_deg(sweep.first_bearing_rad);
  optics.step_deg = rad_to_deg(sweep.bearing_step_rad);
  optics.interlaced_turns = 1;
  optics.scan_duration_s = sweep.beam_interval_s * (sweep.beams - 1);
  optics.no_return_m = HUGE_VAL;
  optics.quantum_m = 0.0;  // the device rounds
  const auto moment = [&](double after_s) -> LaserMoment {
    const Utime when = sweep.first_beam + Duration::from_seconds(after_s);
    return {world_from_sensor_(when), when.seconds()};
  };
  const std::vector<float> ranges_m = LaserModel(rays_, optics).scan(moment, random_);
  std::vector<double> answer(ranges_m.begin(), ranges_m.end());
  if (faults_.has(spec_.port, FaultKind::wrong, sweep.first_beam)) {
    for (double& range_m : answer) range_m += kWrongRangeM;
  }
  std::vector<double>& last =
      last_answers_[std::lround(rad_to_deg(sweep.first_bearing_rad) * kSectorsPerDeg)];
  const bool is_stuck = faults_.has(spec_.port, FaultKind::stuck, sweep.first_beam);
  if (!is_stuck || last.size() != answer.size()) last = answer;
  return last;
}

}  // namespace marco::sim
