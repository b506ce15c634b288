#include "drivers/p2os/sonar_collector.hpp"

namespace marco::drivers::p2os {

SonarCollector::SonarCollector(double cone_rad) {
  ring_.cone_rad = cone_rad;
  for (const Pose2& robot_from_sonar : p2dx_sonars()) {
    ring_.readings.push_back({0.0, robot_from_sonar});
  }
}

std::optional<SonarRing> SonarCollector::add(const Sip& sip, const Model& model, Utime now) {
  constexpr double kNoEchoM = 5.0;
  constexpr double kRingS = 0.4;  // sixteen readings, four a packet
  const double m = model.mm_per_range * 1e-3;
  for (const Sip::Sonar& sonar : sip.sonars) {
    if (sonar.number >= ring_.readings.size()) continue;
    const double range_m = sonar.range * m;
    ring_.readings[sonar.number].range_m = range_m < kNoEchoM - 0.001 ? range_m : 0.0;
  }
  if ((now - last_ring_).seconds() < kRingS) return std::nullopt;
  last_ring_ = ring_.utime = now;
  return ring_;
}

}  // namespace marco::drivers::p2os
