// The emulator's SCIP 1.1, the language of the first URG-04LX: echo, one character of status, data
// without checksums, an empty line. Its distances have two characters; the laser is always on.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/hokuyo/emulator.hpp"

namespace marco::drivers::hokuyo {
namespace {

constexpr int kLastStep = 768;
constexpr long kLargest_mm = 4095;

}  // namespace

void HokuyoEmulator::handle_scip1(const std::string& line, Utime now) {
  std::string status = "0", data;
  int first = 0, last = 0, cluster = 0, used = 0;
  char scan[2] = "";
  if (line == "SCIP2.0") {
    scip1_ = false;
  } else if (line == "V") {
    data =
        "VEND:Hokuyo Automatic Co.,Ltd.\nPROD:SOKUIKI Sensor URG-04LX\nFIRM:1.1.00\n"
        "PROT:SCIP 1.1\nSERI:H0000001\n";
  } else if (line == "L0" || line == "L1") {
    laser_on_ = line == "L1";
  } else if (line.size() == 14 && line[0] == 'S' && baud_ != 0) {
    baud_after_reply_ = std::atoi(line.substr(1, 6).c_str());
    if (baud_after_reply_ != 19'200 && baud_after_reply_ != 57'600 &&
        baud_after_reply_ != 115'200) {
      baud_after_reply_ = 0;
      status = "E";
    }
  } else if (std::sscanf(line.c_str(), "%1[G]%3d%3d%2d%n", scan, &first, &last, &cluster, &used) ==
                 4 &&
             used == 9 && line.size() == 9 && first <= last && last <= kLastStep) {
    data = scip1_scan(first, last, std::max(1, cluster), now);
  } else {
    status = "E";
  }
  const std::string reply = line + "\n" + status + "\n" + data + "\n";
  // A scan is told when the turn that measures it has ended.
  const double wait_s =
      options_.reply_s + (scan[0] != '\0' && status == "0" ? 2.0 * turn_s() : 0.0);
  output_.send(Bytes(reply.begin(), reply.end()), now + Duration::from_seconds(wait_s));
}

std::string HokuyoEmulator::scip1_scan(int first_step,
                                       int last_step,
                                       int cluster,
                                       Utime now) const {
  const double turns = std::ceil((now - power_on_).seconds() / turn_s());
  const double step_rad = 2.0 * std::numbers::pi / parameters_.steps_per_turn;
  const int seen_first = std::max(first_step, parameters_.first_step);
  const int seen_last = std::min(last_step, parameters_.last_step);
  LaserSweep sweep;
  sweep.first_beam =
      turn_start(static_cast<int64_t>(turns)) + Duration::from_seconds(from_rear_s(seen_first));
  sweep.beam_interval_s = turn_s() / parameters_.steps_per_turn;
  sweep.first_bearing_rad = (seen_first - parameters_.front_step) * step_rad;
  sweep.bearing_step_rad = step_rad;
  sweep.beams = std::max(0, seen_last - seen_first + 1);
  const std::vector<double> ranges_m = world_(sweep);
  std::string values;
  for (int step = first_step; step <= last_step; step += cluster) {
    // The nearest of the steps that are merged; 0 where it does not look.
    uint32_t least = 0;
    for (int one = step; one < std::min(step + cluster, last_step + 1); ++one) {
      if (one < seen_first || one > seen_last) continue;
      const double range_m = ranges_m[static_cast<std::size_t>(one - seen_first)];
      if (!std::isfinite(range_m)) continue;
      const long mm = std::lround(range_m * 1000.0);
      if (mm < parameters_.range_min_mm || mm > kLargest_mm) continue;
      least = least == 0 ? static_cast<uint32_t>(mm) : std::min(least, static_cast<uint32_t>(mm));
    }
    values += encode_number(least, 2);
  }
  std::string lines;
  for (std::size_t at = 0; at < values.size(); at += kBlock) {
    lines += values.substr(at, kBlock) + "\n";
  }
  return lines;
}

}  // namespace marco::drivers::hokuyo
