#include "simulator/live/live_laser.hpp"

#include <cmath>
#include <utility>

#include "drivers/cola/emulator.hpp"
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

template <class Options>
using Models = std::vector<std::pair<const char*, Options>>;

/// @returns nullptr when none of the models is the spec's.
template <class Emulator, class Options>
std::unique_ptr<Emulator> emulator_of(const LiveLaserSpec& spec,
                                      const drivers::LaserWorld& world,
                                      const Models<Options>& models) {
  for (const auto& [device, model] : models) {
    if (spec.device != device) continue;
    Options options = model;
    if constexpr (requires { options.baud; }) {
      if (spec.baud > 0) options.baud = spec.baud;
    }
    return std::make_unique<Emulator>(world, options);
  }
  return nullptr;
}

}  // namespace

std::unique_ptr<drivers::Emulator> laser_emulator(const LiveLaserSpec& spec,
                                                  drivers::LaserWorld world) {
  if (spec.device == "sick") {
    drivers::sick::SickEmulatorOptions options;
    if (spec.baud > 0) options.baud = spec.baud;
    options.power_on_s = 1.0;
    return std::make_unique<drivers::sick::SickEmulator>(std::move(world), options);
  }
  if (auto laser = emulator_of<drivers::hokuyo::HokuyoEmulator>(
          spec, world,
          Models<drivers::hokuyo::HokuyoEmulatorOptions>{{"hokuyo", {}},
                                                         {"hokuyo_scip1", {.scip1 = true}},
                                                         {"hokuyo_utm", {"UTM-30LX"}},
                                                         {"hokuyo_ust", {"UST-10LX"}}})) {
    return laser;
  }
  drivers::rplidar::RplidarEmulatorOptions a2;
  a2.model = 0x28;
  a2.turns_per_s = 10.0;
  if (auto laser = emulator_of<drivers::rplidar::RplidarEmulator>(
          spec, world,
          Models<drivers::rplidar::RplidarEmulatorOptions>{
              {"rplidar", {}},
              {"rplidar_a2", a2},
              {"rplidar_a3", drivers::rplidar::a3()},
              {"rplidar_s1", drivers::rplidar::s1()},
              {"rplidar_c1", drivers::rplidar::c1()},
              {"rplidar_s2", drivers::rplidar::s2()},
              {"rplidar_s3", drivers::rplidar::s3()}})) {
    return laser;
  }
  if (auto laser = emulator_of<drivers::ldlidar::LdlidarEmulator>(
          spec, world,
          Models<drivers::ldlidar::LdlidarEmulatorOptions>{
              {"ld19", {}}, {"stl27l", drivers::ldlidar::stl27l()}})) {
    return laser;
  }
  if (auto laser = emulator_of<drivers::ydlidar::YdlidarEmulator>(
          spec, world,
          Models<drivers::ydlidar::YdlidarEmulatorOptions>{
              {"ydlidar_x2", drivers::ydlidar::x2()},
              {"ydlidar_x4", {}},
              {"ydlidar_g4", drivers::ydlidar::g4()}})) {
    return laser;
  }
  if (auto laser = emulator_of<drivers::cola::ColaEmulator>(
          spec, world,
          Models<drivers::cola::ColaEmulatorOptions>{{"tim551", drivers::cola::tim551()},
                                                     {"tim561", {}},
                                                     {"lms111", drivers::cola::lms111()}})) {
    return laser;
  }
  // The Rotoscan of thesis A, out of calibration as it was.
  if (spec.device == "leuze_service") {
    return std::make_unique<drivers::leuze::LeuzeServiceEmulator>(
        std::move(world), drivers::leuze::thesis_a_geometry());
  }
  require(spec.device == "leuze",
          "lasers.device '" + spec.device +
              "': expected sick, leuze, leuze_service, hokuyo, rplidar, "
              "rplidar_a2, rplidar_a3, rplidar_s1, rplidar_c1, rplidar_s2, rplidar_s3, "
              "ld19, stl27l, ydlidar_x2, ydlidar_x4, ydlidar_g4, "
              "hokuyo_scip1, hokuyo_utm, hokuyo_ust, tim551, tim561 or lms111");
  drivers::leuze::LeuzeEmulatorOptions options;
  if (spec.baud > 0) options.baud = spec.baud;
  if (spec.tcp_port >= 0) options.baud = 0;
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
