#pragma once

#include <optional>
#include <vector>

#include "drivers/laser/turn_gatherer.hpp"

namespace marco::drivers {

/// Some samples of a rotating head, sent together, at even steps of angle.
struct SamplePacket {
  struct Sample {
    double angle_deg = 0.0;    ///< of the head, growing as it turns, 0..360
    double bearing_rad = 0.0;  ///< of the return, sensor frame, counter-clockwise from ahead
    double range_m = 0.0;      ///< 0 = no return
    double intensity = 0.0;    ///< device units; 0 = not measured
  };
  std::vector<Sample> samples;
  bool continuous = true;  ///< no bytes were skipped since the packet before
  double clock_s = 0.0;  ///< when it left: by the laser's clock, or by the host's where it has none
  Utime left;            ///< when it left the laser, by its arrival
  Utime arrival;         ///< of its last byte
};

/// Gathers the packets of a laser that takes its samples at a fixed period into turns; a turn ends
/// where the angle wraps. Learns the period. A turn may miss samples of lost packets: the angles
/// tell how many, so that the others keep their times. One thread.
class PacketTurns {
 public:
  struct Timing {
    bool laser_has_clock = false;  ///< clock_s is the laser's own
    double learn_s = 1.0;          ///< how long the period is learned
  };
  explicit PacketTurns(const Timing& timing) : timing_(timing) {}

  void add(const SamplePacket& packet);
  /// Packets were lost, nobody knows how many: drops the turn under way.
  void lose_count();
  /// Another stream begins, perhaps of another period.
  void restart();

  std::vector<ArrivedScan> take_scans() { return gatherer_.take_scans(); }
  double turn_s() const { return gatherer_.turn_s(); }
  /// Samples a second; 0 until it is learned.
  double sample_rate_hz() const { return learned_ ? 1.0 / clock_.host_sample_s() : 0.0; }
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  const ClockFilter& filter() const { return clock_.filter(); }

 private:
  /// Sums of a straight line through times over counts.
  struct Learning {
    double since_s = 0.0;
    double packets = 0.0;
    double samples = 0.0;
    double sum_x = 0.0, sum_y = 0.0, sum_xx = 0.0, sum_xy = 0.0;

    void add(double x, double y);
    double slope() const;
  };
  struct Last {
    double angle_deg = 0.0;
    double step_deg = 0.0;
    double clock_s = 0.0;
  };

  int64_t lost_samples(const SamplePacket& packet, double step_deg) const;
  void learn(const SamplePacket& packet, bool gapless);
  void mind_gap(const SamplePacket& packet, double step_deg, int64_t lost);
  void gather(const SamplePacket& packet);

  Timing timing_;
  SampleClock clock_{kMaxDrift};
  TurnGatherer gatherer_{clock_};
  std::optional<Last> last_;
  std::optional<Learning> learning_;
  bool learned_ = false;
  LaserCounts counts_;

  static constexpr double kMaxDrift = 0.05;
};

}  // namespace marco::drivers
