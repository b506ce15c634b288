#pragma once

#include <string>

#include "drivers/hokuyo/codec.hpp"
#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "drivers/transport/clock_filter.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::hokuyo {

struct HokuyoOptions {
  int baud = 0;     ///< to measure at, on RS-232; 0 = USB or TCP, which have none
  int cluster = 1;  ///< steps merged to one beam
  int skip = 0;     ///< turns left out between two scans
  double range_sigma_m = 0.01;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{0, 750'000});
    v("cluster", cluster, Limits{1, 99});
    v("skip", skip, Limits{0, 9});
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }
};

/// Stops what the laser does, brings it to SCIP 2.0 and to its speed, asks its parameters and lets
/// it stream. Starts over when it falls silent. Times come from the laser's own clock
/// (milliseconds) brought to ours; ranges that are error codes become 0.
class HokuyoDriver final : public LaserDriver {
 public:
  /// @param stream  outlives the driver.
  HokuyoDriver(ByteStream& stream, const HokuyoOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_line_emptied() override;
  std::string state() const override;
  bool answers() const override { return phase_ != Phase::finding; }
  LaserSight sight() const override;
  const LaserCounts& counts() const override { return counts_; }
  void stop() override { send("QT"); }

  bool measuring() const { return phase_ == Phase::measuring; }

 private:
  enum class Phase { finding, changing_baud, asking_parameters, laser_on, starting, measuring };

  void enter(Phase phase);
  void ask();
  std::string request_of(Phase phase) const;
  void send(const std::string& line);
  void set_baud(int baud);
  void look_elsewhere();
  void start_over(const std::string& why);
  void on_reply(const Reply& reply, Utime arrival);
  void on_answer(const Reply& reply);
  void on_measurement(const Reply& reply, Utime arrival);
  void on_timeout();
  double turn_s() const { return 60.0 / parameters_.rpm; }
  double from_rear_s(int step) const;

  ByteStream& stream_;
  HokuyoOptions options_;
  Clock clock_;
  ReplyParser parser_;
  Phase phase_ = Phase::finding;
  std::vector<int> rates_;
  std::size_t rate_ = 0;
  bool looked_ = false;
  int baud_ = 0;  ///< 0 = none
  int tries_ = 0;
  Utime deadline_;
  Utime last_scan_;
  Parameters parameters_;
  ScanRequest request_;
  std::string trouble_;
  ClockFilter filter_;
  int64_t device_ms_ = 0;  ///< unwrapped
  uint32_t last_stamp_ms_ = 0;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers::hokuyo
