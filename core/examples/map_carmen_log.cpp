// A CARMEN log (FLASER lines) from stdin: the robot's path to stdout, the map to map.pgm.
#include <fstream>
#include <iostream>
#include <numbers>
#include <sstream>

#include "core/mapper.hpp"

int main() {
  marco::Mapper mapper;
  mapper.add(marco::SensorInfo());  // on the robot's centre, 80 m
  std::string line, word;
  while (std::getline(std::cin, line)) {
    std::istringstream fields(line);
    std::size_t beams = 0;
    if (!(fields >> word >> beams) || word != "FLASER") continue;
    marco::LaserScan scan;
    scan.ranges_m.resize(beams);
    for (float& range_m : scan.ranges_m) fields >> range_m;
    double x_m, y_m, theta_rad, skipped, time_s;
    fields >> skipped >> skipped >> skipped >> x_m >> y_m >> theta_rad >> time_s;
    scan.utime = marco::Utime::from_seconds(time_s);
    scan.first_bearing_rad = -std::numbers::pi / 2;
    scan.bearing_step_rad = std::numbers::pi / static_cast<double>(beams);
    mapper.add(marco::OdometrySample{scan.utime, {x_m, y_m, theta_rad}});
    mapper.add(scan);
  }
  mapper.finish();
  for (const auto& [utime, pose] : mapper.path()) {
    std::cout << std::fixed << utime.seconds() << ' ' << pose.x_m << ' ' << pose.y_m << ' '
              << pose.theta_rad << '\n';
  }
  const marco::GridMap map = mapper.map();
  std::ofstream file("map.pgm");
  file << "P5\n" << map.width_cells << ' ' << map.height_cells << "\n255\n";
  for (int y = map.height_cells; y-- > 0;) {
    for (int x = 0; x < map.width_cells; ++x) {
      file.put(static_cast<char>(
          map.at(x, y) == marco::GridMap::kUnknown ? 205 : 254 - 254 * map.at(x, y) / 100));
    }
  }
  std::cerr << "the map is " << to_string(mapper.verdict().verdict) << '\n';
}
