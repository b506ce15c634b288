#pragma once

#include <optional>
#include <string>

#include "drivers/p2os/accessories.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers::p2os {

/// What the robot has and how it is set. It is asked (CONFIG) until it answers or has shown that it
/// does not, as old firmware.
class Outfit {
 public:
  /// @param bumpers_each_end  of a robot that does not tell.
  explicit Outfit(int bumpers_each_end) : bumpers_each_end_(bumpers_each_end) {}

  void restart() { config_.reset(), times_asked_ = 0; }
  void on_asked(Utime now);
  /// @returns false for a damaged packet.
  bool on_config(std::span<const uint8_t> payload);
  bool must_ask(Utime now) const;
  bool known(Utime now) const;
  /// What a person should know; "" = nothing.
  std::string note() const;

  struct Bumpers {
    std::vector<int> front_pressed;  ///< numbers, 1 = the leftmost
    std::vector<int> rear_pressed;
    std::vector<bool> all;
  };
  Bumpers bumpers(const Sip& sip) const;

 private:
  int bumpers_each_end_;
  std::optional<RobotConfig> config_;
  int times_asked_ = 0;
  Utime next_ask_;
};

}  // namespace marco::drivers::p2os
