#include "simulator/live/live_laser.hpp"

#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "simulator/devices/cola/emulator.hpp"
#include "simulator/devices/hokuyo/emulator.hpp"
#include "simulator/devices/ldlidar/emulator.hpp"
#include "simulator/devices/leuze/service_emulator.hpp"
#include "simulator/devices/rplidar/emulator.hpp"
#include "simulator/devices/sick/emulator.hpp"
#include "simulator/devices/ydlidar/emulator.hpp"

namespace marco::sim {
namespace {

constexpr double kWrongRangeM = 0.2;  // of the fault `wrong`
constexpr double kSectorsPerDeg = 10.0;

using EmulatorMaker =
    std::function<std::unique_ptr<drivers::Emulator>(const LiveLaserSpec&, drivers::LaserWorld)>;

// At the baud rate of the specification, where it gives one.
template <class Emulator, class Options>
EmulatorMaker made_of(Options options) {
  return [options](const LiveLaserSpec& spec, drivers::LaserWorld world) mutable {
    if constexpr (requires { options.baud; }) {
      if (spec.baud > 0) options.baud = spec.baud;
    }
    return std::make_unique<Emulator>(std::move(world), options);
  };
}

// The Rotoscan of thesis A, out of calibration as it was.
std::unique_ptr<drivers::Emulator> leuze_service(const LiveLaserSpec& /*spec*/,
                                                 drivers::LaserWorld world) {
  return std::make_unique<drivers::leuze::LeuzeServiceEmulator>(
      std::move(world), drivers::leuze::thesis_a_geometry());
}

std::unique_ptr<drivers::Emulator> leuze_measuring(const LiveLaserSpec& spec,
                                                   drivers::LaserWorld world) {
  drivers::leuze::LeuzeEmulatorOptions options;
  if (spec.baud > 0) options.baud = spec.baud;
  if (spec.tcp_port >= 0) options.baud = 0;
  options.geometry.scale = drivers::leuze::thesis_a_geometry().scale;
  return std::make_unique<drivers::leuze::LeuzeEmulator>(std::move(world), options);
}

const std::vector<std::pair<std::string, EmulatorMaker>>& devices() {
  using namespace drivers;
  using Hokuyo = hokuyo::HokuyoEmulatorOptions;
  using Rplidar = rplidar::RplidarEmulatorOptions;
  static const std::vector<std::pair<std::string, EmulatorMaker>> kDevices{
      {"sick", made_of<sick::SickEmulator>(sick::SickEmulatorOptions{.power_on_s = 1.0})},
      {"leuze", leuze_measuring},
      {"leuze_service", leuze_service},
      {"hokuyo", made_of<hokuyo::HokuyoEmulator>(Hokuyo{})},
      {"rplidar", made_of<rplidar::RplidarEmulator>(Rplidar{})},
      {"rplidar_a2",
       made_of<rplidar::RplidarEmulator>(Rplidar{.model = 0x28, .turns_per_s = 10.0})},
      {"rplidar_a3", made_of<rplidar::RplidarEmulator>(rplidar::a3())},
      {"rplidar_s1", made_of<rplidar::RplidarEmulator>(rplidar::s1())},
      {"rplidar_c1", made_of<rplidar::RplidarEmulator>(rplidar::c1())},
      {"rplidar_s2", made_of<rplidar::RplidarEmulator>(rplidar::s2())},
      {"rplidar_s3", made_of<rplidar::RplidarEmulator>(rplidar::s3())},
      {"ld19", made_of<ldlidar::LdlidarEmulator>(ldlidar::LdlidarEmulatorOptions{})},
      {"stl27l", made_of<ldlidar::LdlidarEmulator>(ldlidar::stl27l())},
      {"ydlidar_x2", made_of<ydlidar::YdlidarEmulator>(ydlidar::x2())},
      {"ydlidar_x4", made_of<ydlidar::YdlidarEmulator>(ydlidar::YdlidarEmulatorOptions{})},
      {"ydlidar_g4", made_of<ydlidar::YdlidarEmulator>(ydlidar::g4())},
      {"hokuyo_scip1", made_of<hokuyo::HokuyoEmulator>(Hokuyo{.scip1 = true})},
      {"hokuyo_utm", made_of<hokuyo::HokuyoEmulator>(Hokuyo{.model = "UTM-30LX"})},
      {"hokuyo_ust", made_of<hokuyo::HokuyoEmulator>(Hokuyo{.model = "UST-10LX"})},
      {"tim551", made_of<cola::ColaEmulator>(cola::tim551())},
      {"tim561", made_of<cola::ColaEmulator>(cola::ColaEmulatorOptions{})},
      {"lms111", made_of<cola::ColaEmulator>(cola::lms111())}};
  return kDevices;
}

}  // namespace

std::unique_ptr<drivers::Emulator> laser_emulator(const LiveLaserSpec& spec,
                                                  drivers::LaserWorld world) {
  std::string known;
  for (const auto& [device, make] : devices()) {
    if (spec.device == device) return make(spec, std::move(world));
    known += (known.empty() ? "" : device == devices().back().first ? " or " : ", ") + device;
  }
  throw std::invalid_argument("lasers.device '" + spec.device + "': expected " + known);
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
