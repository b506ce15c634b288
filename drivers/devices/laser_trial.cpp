#include "drivers/devices/laser_trial.hpp"

#include <memory>
#include <stdexcept>

#include "drivers/cola/driver.hpp"
#include "drivers/hokuyo/driver.hpp"
#include "drivers/ldlidar/driver.hpp"
#include "drivers/leuze/driver.hpp"
#include "drivers/rplidar/driver.hpp"
#include "drivers/ydlidar/driver.hpp"

namespace marco::drivers::devices {
namespace {

constexpr double kPatienceS = 10.0;
constexpr int kHokuyoBaud = 115'200;  // its fastest on RS-232
constexpr int kScans = 5;             // the first is not whole, or late

std::unique_ptr<LaserDriver> driver_of(Kind laser,
                                       int baud,
                                       ByteStream& stream,
                                       const Clock& clock) {
  if (laser == Kind::ldlidar) {
    return std::make_unique<ldlidar::LdlidarDriver>(stream, ldlidar::LdlidarOptions{}, clock);
  }
  if (laser == Kind::ydlidar) {
    return std::make_unique<ydlidar::YdlidarDriver>(stream, ydlidar::YdlidarOptions{}, clock);
  }
  if (laser == Kind::rplidar) {
    rplidar::RplidarOptions options;
    options.baud = baud;
    return std::make_unique<rplidar::RplidarDriver>(stream, options, clock);
  }
  if (laser == Kind::hokuyo) {
    hokuyo::HokuyoOptions options;
    // One on USB understands at any rate, and knows none. TCP has none.
    options.baud = baud == kHokuyoBaud || baud == 0 ? 0 : kHokuyoBaud;
    return std::make_unique<hokuyo::HokuyoDriver>(stream, options, clock);
  }
  if (laser == Kind::cola) {
    return std::make_unique<cola::ColaDriver>(stream, cola::ColaOptions{}, clock);
  }
  leuze::LeuzeOptions options;
  options.baud = baud;
  return std::make_unique<leuze::LeuzeDriver>(stream, options, clock);
}

}  // namespace

bool may_be_tried(Kind laser) { return is_laser(laser) && laser != Kind::sick; }

LaserTrial try_laser(ByteStream& stream, const Clock& clock, Kind laser, int baud) {
  if (!may_be_tried(laser)) throw std::logic_error("no trial for this laser");
  const auto driver = driver_of(laser, baud, stream, clock);
  LaserTrial trial;
  const Utime begin = clock();
  Utime first, last;
  int scans = 0;
  while (scans < kScans && (clock() - begin).seconds() < kPatienceS) {
    for (const ArrivedScan& arrived : driver->step()) {
      if (++scans == 1) first = arrived.scan.utime;
      last = arrived.scan.utime;
      trial.beams = arrived.scan.size();
    }
  }
  if (scans > 1 && last > first) trial.scans_per_s = (scans - 1) / (last - first).seconds();
  trial.state = driver->state();
  driver->stop();
  return trial;
}

}  // namespace marco::drivers::devices
