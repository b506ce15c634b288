#include "drivers/hokuyo/scip1.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace marco::drivers::hokuyo {
namespace {

constexpr int kLastStep = 768;
constexpr long kLargestMm = 4095;
constexpr std::array kBauds{19'200, 57'600, 115'200};

// The nearest of the merged steps; 0 where the laser does not look.
uint32_t nearest_mm(const std::vector<double>& ranges_m, int from, int to, int range_min_mm) {
  uint32_t least = 0;
  for (int i = std::max(0, from); i < std::min(to, static_cast<int>(ranges_m.size())); ++i) {
    const double range_m = ranges_m[static_cast<std::size_t>(i)];
    if (!std::isfinite(range_m)) continue;
    const long mm = std::lround(range_m * 1000.0);
    if (mm < range_min_mm || mm > kLargestMm) continue;
    least = least == 0 ? static_cast<uint32_t>(mm) : std::min(least, static_cast<uint32_t>(mm));
  }
  return least;
}

std::string scan_lines(
    const HokuyoMirror& mirror, int first_step, int last_step, int cluster, Utime now) {
  const Parameters& parameters = mirror.parameters();
  const int seen_first = std::max(first_step, parameters.first_step);
  const int seen_last = std::min(last_step, parameters.last_step);
  const std::vector<double> ranges_m =
      mirror.ranges_m(seen_first, seen_last, mirror.turn_after(now));
  std::string values;
  for (int step = first_step; step <= last_step; step += cluster) {
    const int end = std::min(step + cluster, last_step + 1);
    values += encode_number(
        nearest_mm(ranges_m, step - seen_first, end - seen_first, parameters.range_min_mm), 2);
  }
  std::string lines;
  for (std::size_t at = 0; at < values.size(); at += kBlock) {
    lines += values.substr(at, kBlock) + "\n";
  }
  return lines;
}

}  // namespace

Scip1Answer answer_scip1(const std::string& line,
                         const HokuyoMirror& mirror,
                         bool has_baud,
                         Utime now) {
  Scip1Answer answer;
  std::string status = "0", data;
  int first = 0, last = 0, cluster = 0, used = 0;
  char command[2] = "";
  if (line == "SCIP2.0") {
    answer.leave = true;
  } else if (line == "V") {
    data =
        "VEND:Hokuyo Automatic Co.,Ltd.\nPROD:SOKUIKI Sensor URG-04LX\nFIRM:1.1.00\n"
        "PROT:00003,(SCIP 1.0)\nSERI:H0000001\nSTAT:Sensor works well.\n";
  } else if (line == "L0" || line == "L1") {
    answer.laser_on = line == "L1";
  } else if (line.size() == 14 && line[0] == 'S' && has_baud) {
    const int baud = std::atoi(line.substr(1, 6).c_str());
    const bool known = std::find(kBauds.begin(), kBauds.end(), baud) != kBauds.end();
    answer.baud = known ? baud : 0;
    if (!known) status = "E";
  } else if (std::sscanf(line.c_str(), "%1[G]%3d%3d%2d%n", command, &first, &last, &cluster,
                         &used) == 4 &&
             used == 9 && line.size() == 9 && first <= last && last <= kLastStep) {
    data = scan_lines(mirror, first, last, std::max(1, cluster), now);
    answer.scan = true;
  } else {
    status = "E";
  }
  answer.text = line + "\n" + status + "\n" + data + "\n";
  return answer;
}

}  // namespace marco::drivers::hokuyo
