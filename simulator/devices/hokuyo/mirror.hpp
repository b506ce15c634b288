#pragma once

#include <utility>

#include "drivers/hokuyo/codec.hpp"
#include "simulator/devices/laser_world.hpp"

namespace marco::drivers::hokuyo {

/// The measuring half of the emulated laser: when its mirror points where, and what it sees there.
/// Turns are counted from power-on; each begins at the rear.
class HokuyoMirror {
 public:
  HokuyoMirror(LaserWorld world, Parameters parameters)
      : world_(std::move(world)), parameters_(std::move(parameters)) {}

  void set_power_on(Utime now) { power_on_ = now; }
  bool powered() const { return power_on_.us != 0; }
  const Parameters& parameters() const { return parameters_; }

  /// Of the laser's clock, 24 bits.
  uint32_t clock_ms(Utime now) const;
  /// The first turn that begins after.
  int64_t turn_after(Utime when) const;
  Utime time_of(int64_t turn, int step) const;
  double turn_s() const { return 60.0 / parameters_.rpm; }

  Measurement measure(const ScanRequest& request, int64_t turn);
  /// Ranges [m] of single steps.
  std::vector<double> ranges_m(int first_step, int last_step, int64_t turn) const;
  Utime last_first_beam() const { return last_first_beam_; }

 private:
  LaserWorld world_;
  Parameters parameters_;
  Utime power_on_;
  Utime last_first_beam_;
};

}  // namespace marco::drivers::hokuyo
