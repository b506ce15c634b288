#pragma once

#include <optional>

#include "common/robot_values.hpp"
#include "drivers/p2os/codec.hpp"

namespace marco::drivers::p2os {

/// Collects the readings of information packets, four at a time, to rings of sixteen.
class SonarCollector {
 public:
  explicit SonarCollector(double cone_rad);

  /// @returns the ring each 0.4 s.
  std::optional<SonarRing> add(const Sip& sip, const Model& model, Utime now);
  /// The host's clock may have been set back.
  void forget_stamps() { last_ring_ = {}; }

 private:
  SonarRing ring_;
  Utime last_ring_;
};

}  // namespace marco::drivers::p2os
