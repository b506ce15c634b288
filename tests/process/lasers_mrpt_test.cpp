// The only judge that does not share our reading of the manuals: MRPT's drivers read our emulators.
#include <gmock/gmock.h>
#include <mrpt/hwdrivers/CHokuyoURG.h>
#include <mrpt/hwdrivers/CRoboPeakLidar.h>
#include <mrpt/hwdrivers/CSickLaserSerial.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <atomic>
#include <cmath>
#include <mutex>
#include <thread>

#include "drivers/transport/wall_clock.hpp"
#include "simulator/devices/hokuyo/emulator.hpp"
#include "simulator/devices/laser_world.hpp"
#include "simulator/devices/rplidar/emulator.hpp"
#include "simulator/devices/sick/emulator.hpp"
#include "simulator/devices/transport/emulator_port.hpp"

namespace marco::drivers {
namespace {

using mrpt::hwdrivers::C2DRangeFinderAbstract;
using mrpt::obs::CObservation2DRangeScan;
using Ranges = std::vector<double>;

// A world that differs with every scan and remembers what it told; 0.8 to 5.3 m.
class Witness {
 public:
  Ranges operator()(const LaserSweep& sweep) {
    const std::lock_guard lock(mutex_);
    Ranges ranges_m;
    for (int i = 0; i < sweep.beams; ++i) {
      const double bearing_rad = sweep.first_bearing_rad + i * sweep.bearing_step_rad;
      ranges_m.push_back(2.8 + 2.0 * std::sin(5.0 * bearing_rad) +
                         0.01 * static_cast<double>(told_.size() % 50));
    }
    told_.push_back(ranges_m);
    return ranges_m;
  }
  std::vector<Ranges> told() {
    const std::lock_guard lock(mutex_);
    return told_;
  }

 private:
  std::mutex mutex_;
  std::vector<Ranges> told_;
};

// Serves the port on a thread of its own, as MRPT blocks while it waits.
class Served {
 public:
  explicit Served(EmulatorPort& port)
      : thread_([this, &port] {
          std::array<EmulatorPort*, 1> ports{&port};
          while (!stop_) serve_ports(ports, Duration::from_us(5000));
        }) {}
  ~Served() {
    stop_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

std::vector<CObservation2DRangeScan> grab(C2DRangeFinderAbstract& laser,
                                          std::size_t count,
                                          double limit_s) {
  std::vector<CObservation2DRangeScan> scans;
  const Utime limit = wall_now() + Duration::from_seconds(limit_s);
  while (scans.size() < count && wall_now() < limit) {
    bool there = false;
    bool error = false;
    CObservation2DRangeScan scan;
    laser.doProcessSimple(there, scan, error);
    if (there) scans.push_back(scan);
    if (!there) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return scans;
}

// How many values of `scan` are not those of the scan `told`, to half a unit.
int differing(const CObservation2DRangeScan& scan, const Ranges& told, double unit_m) {
  if (scan.getScanSize() != told.size()) return 1 << 20;
  int wrong = 0;
  for (std::size_t i = 0; i < told.size(); ++i) {
    const double got_m = static_cast<double>(scan.getScanRange(i));
    wrong += std::abs(got_m - told[i]) > 0.5 * unit_m + 1e-5 ? 1 : 0;
  }
  return wrong;
}

// Each scan must equal, value by value, one that was told, each a later one than the last.
void expect_told(const std::vector<CObservation2DRangeScan>& scans,
                 const std::vector<Ranges>& told,
                 double unit_m) {
  std::size_t next = 0;
  for (const CObservation2DRangeScan& scan : scans) {
    while (next < told.size() && differing(scan, told[next], unit_m) > 0) ++next;
    EXPECT_LT(next, told.size()) << "a scan that was never sent";
    ++next;
  }
}

struct SickCase {
  int baud, angle_deg, resolution_cdeg;
  bool millimetres;
};

// Two or four turns make one scan.
std::vector<Ranges> merge_turns(const std::vector<Ranges>& turns, std::size_t per_scan) {
  std::vector<Ranges> scans;
  for (std::size_t first = 0; first + per_scan <= turns.size(); first += per_scan) {
    Ranges scan((turns[first].size() - 1) * per_scan + 1);
    for (std::size_t turn = 0; turn < per_scan; ++turn) {
      for (std::size_t i = 0; i < turns[first + turn].size(); ++i) {
        scan[i * per_scan + turn] = turns[first + turn][i];
      }
    }
    scans.push_back(scan);
  }
  return scans;
}

void read_sick(const SickCase& one) {
  Witness witness;
  sick::SickEmulator emulator(std::ref(witness), {});
  EmulatorPort port = EmulatorPort::pty(emulator);
  Served served(port);
  mrpt::hwdrivers::CSickLaserSerial laser;
  laser.setSerialPort(port.address());
  laser.setBaudRate(one.baud);
  laser.setMillimeterMode(one.millimetres);
  laser.setScanFOV(one.angle_deg);
  laser.setScanResolution(one.resolution_cdeg);
  const auto scans = grab(laser, one.baud == 9600 ? 4 : 10, 12.0);
  std::printf("MRPT, SICK, %d baud, %d/%.2f deg, %s: %zu scans\n", one.baud, one.angle_deg,
              one.resolution_cdeg * 0.01, one.millimetres ? "mm" : "cm", scans.size());
  EXPECT_GE(scans.size(), 4u);
  const auto turns_per_scan = 100u / static_cast<unsigned>(one.resolution_cdeg);
  expect_told(scans, merge_turns(witness.told(), turns_per_scan), one.millimetres ? 0.001 : 0.01);
}

// All at once: they mostly wait. Not among them: 100/0.25 deg, whose 812 bytes MRPT refuses.
TEST(Mrpt, ReadsOurSick) {
  std::vector<std::thread> readers;
  for (const SickCase& one : {SickCase{38400, 180, 50, true}, SickCase{38400, 180, 50, false},
                              SickCase{500'000, 180, 50, true}, SickCase{500'000, 100, 50, true},
                              SickCase{38400, 180, 100, true}, SickCase{500'000, 100, 100, false},
                              SickCase{9600, 180, 100, false}}) {
    readers.emplace_back(read_sick, one);
  }
  for (std::thread& reader : readers) reader.join();
}

TEST(Mrpt, ReadsOurHokuyo) {
  for (const char* model : {"URG-04LX", "UTM-30LX"}) {
    Witness witness;
    hokuyo::HokuyoEmulatorOptions options;
    options.model = model;
    hokuyo::HokuyoEmulator emulator(std::ref(witness), options);
    EmulatorPort port = EmulatorPort::pty(emulator);
    Served served(port);
    mrpt::hwdrivers::CHokuyoURG laser;
    laser.setSerialPort(port.address());
    static_cast<mrpt::hwdrivers::CGenericSensor&>(laser).initialize();
    const auto scans = grab(laser, 10, 8.0);
    std::printf("MRPT, Hokuyo %s: %zu scans of %zu values\n", model, scans.size(),
                scans.empty() ? 0 : scans[0].getScanSize());
    EXPECT_GE(scans.size(), 10u);
    expect_told(scans, witness.told(), 0.001);
  }
}

// MRPT keeps the last range that falls into each of 360 slots, clockwise from ahead, and gives no
// times. MRPT 2.5.8 reads the vendor's angle, whose 90 degrees are 2^14, as 1/128 degree: a slot is
// 90/128 of a degree wide and the last quarter of a turn is lost to it. So each range must be the
// one of the angle at which its slot truly lies.
TEST(Mrpt, ReadsOurRplidar) {
  constexpr double kPi = 3.14159265358979;
  const auto range_m = [](double angle_deg) {
    return 3.0 + 2.0 * std::sin(2.0 * angle_deg * kPi / 180.0);
  };
  const auto world = [&](const LaserSweep& sweep) {
    Ranges ranges_m;
    for (int i = 0; i < sweep.beams; ++i) {
      const double bearing_rad = sweep.first_bearing_rad + i * sweep.bearing_step_rad;
      ranges_m.push_back(range_m(-bearing_rad * 180.0 / kPi));
    }
    return ranges_m;
  };
  for (const int mode : {0, 1}) {
    rplidar::RplidarEmulatorOptions options;
    options.typical_mode = mode;
    rplidar::RplidarEmulator emulator(world, options);
    EmulatorPort port = EmulatorPort::pty(emulator);
    Served served(port);
    mrpt::hwdrivers::CRoboPeakLidar laser;
    laser.setSerialPort(port.address());
    static_cast<mrpt::hwdrivers::CGenericSensor&>(laser).initialize();
    const auto scans = grab(laser, 10, 8.0);
    std::printf("MRPT, RPLIDAR A1 %s: %zu scans of %zu values\n",
                mode == 1 ? "express" : "standard", scans.size(),
                scans.empty() ? 0 : scans[0].getScanSize());
    EXPECT_GE(scans.size(), 10u);
    for (const CObservation2DRangeScan& scan : scans) {
      std::size_t valid = 0;
      for (std::size_t i = 0; i < scan.getScanSize(); ++i) {
        if (!scan.getScanRangeValidity(i)) continue;
        ++valid;
        const double angle_deg = (static_cast<double>(i) + 0.5) * 90.0 / 128.0;
        // 4 m/rad over half a slot, and a millimetre.
        EXPECT_NEAR(static_cast<double>(scan.getScanRange(i)), range_m(angle_deg),
                    4.0 * 45.0 / 128.0 * kPi / 180.0 + 0.001)
            << i;
      }
      EXPECT_GT(valid, mode == 1 ? 300u : 200u);
    }
  }
}

}  // namespace
}  // namespace marco::drivers
