#pragma once

#include <optional>
#include <vector>

#include "common/robot_values.hpp"
#include "drivers/p2os/codec.hpp"
#include "drivers/p2os/models.hpp"

namespace marco::drivers::p2os {

/// Collects the readings of information packets, a few at a time, to rings of all its sonars.
class SonarCollector {
 public:
  explicit SonarCollector(double cone_rad) { ring_.cone_rad = cone_rad; }

  /// Before the first packet.
  void fit(const Model& model);
  /// @returns the ring each 0.4 s, or 0.8 s of more than sixteen; never one without sonars.
  std::optional<SonarRing> add(const Sip& sip, Utime now);
  /// The host's clock may have been set back.
  void forget_stamps() { last_ring_ = {}; }

 private:
  SonarRing ring_;
  std::vector<std::optional<std::size_t>> reading_of_;  ///< by the sonar's number
  double m_per_range_ = 0.0;
  Utime last_ring_;
};

}  // namespace marco::drivers::p2os
