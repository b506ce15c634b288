#pragma once

#include <optional>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "drivers/p2os/codec.hpp"

namespace marco::drivers::p2os {

/// The driver's side of a camera head at the robot's second serial port: packets for the robot,
/// which passes them on.
class HeadClient {
 public:
  Bytes power_on(Utime now);
  Bytes look(const PanTiltCommand& command, Utime now);
  /// The question for the angles, when it is due; else empty.
  Bytes ask(Utime now);
  /// @param payload of a packet AUX. @returns nothing for anything but the answer.
  static std::optional<PanTiltState> decode(std::span<const uint8_t> payload, Utime arrival);

 private:
  Utime next_ask_;
};

}  // namespace marco::drivers::p2os
