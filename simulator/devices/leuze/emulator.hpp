#pragma once

#include "drivers/leuze/codec.hpp"
#include "drivers/leuze/geometry.hpp"
#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/devices/laser_world.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::leuze {

struct LeuzeEmulatorOptions {
  int baud = 57'600;  ///< 0 = TCP
  int step = 4;       ///< 1, 2, 3, 4 or another divisor of 528: 529, 265, 177, 133 beams
  LeuzeGeometry geometry;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{0, 115'200});
    v("step", step, Limits{1, 66});
    v("geometry", geometry);
  }
};

/// Which beams a sweep of the laser measures. @param step  index of a beam to the next
LaserSweep sweep_of(const LeuzeGeometry& geometry, Utime first_beam, int step);
/// A range as the laser measures it: no echo is its largest range.
double measured_m(double range_m);

/// Streams without being asked, one telegram a sweep. Drops those for which the line has no time.
class LeuzeEmulator final : public Emulator {
 public:
  LeuzeEmulator(LaserWorld world, const LeuzeEmulatorOptions& options);

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  int64_t scans_sent() const { return scans_sent_; }
  Utime last_first_beam() const { return last_first_beam_; }

 private:
  Utime sweep_end() const;

  LaserWorld world_;
  LeuzeEmulatorOptions options_;
  PacedOutput output_;
  bool readable_ = true;
  bool connected_ = false;
  Utime start_;
  int64_t sweep_ = 0;  ///< the one under way
  int64_t scans_sent_ = 0;
  Utime last_first_beam_;
};

}  // namespace marco::drivers::leuze
