#include "drivers/p2os/sonar_collector.hpp"

namespace marco::drivers::p2os {

void SonarCollector::fit(const Model& model) {
  m_per_range_ = model.mm_per_range * 1e-3;
  ring_.readings.clear();
  reading_of_.clear();
  for (const std::optional<Pose2>& robot_from_sonar : model.robot_from_sonar) {
    reading_of_.push_back(robot_from_sonar ? std::optional(ring_.readings.size()) : std::nullopt);
    if (robot_from_sonar) ring_.readings.push_back({0.0, *robot_from_sonar});
  }
}

std::optional<SonarRing> SonarCollector::add(const Sip& sip, Utime now) {
  constexpr double kNoEchoM = 5.0;
  constexpr double kSixteenS = 0.4;  // four a packet
  for (const Sip::Sonar& sonar : sip.sonars) {
    if (sonar.number >= reading_of_.size() || !reading_of_[sonar.number]) continue;
    const double range_m = sonar.range * m_per_range_;
    ring_.readings[*reading_of_[sonar.number]].range_m = range_m < kNoEchoM - 0.001 ? range_m : 0.0;
  }
  const double ring_s = reading_of_.size() > 16 ? 2.0 * kSixteenS : kSixteenS;
  if (ring_.readings.empty() || (now - last_ring_).seconds() < ring_s) return std::nullopt;
  last_ring_ = ring_.utime = now;
  return ring_;
}

}  // namespace marco::drivers::p2os
