#pragma once

#include <string>
#include <utility>
#include <vector>

#include "drivers/hokuyo/codec.hpp"
#include "drivers/laser/dialogue.hpp"
#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/baud_search.hpp"
#include "drivers/transport/clock_filter.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::hokuyo {

/// Turns measurements into scans with the time of every beam. The stamps come from the laser's own
/// clock (24 bits of milliseconds). Ranges that are error codes become 0.
class ScanAssembler {
 public:
  /// A stream of scans starts. @param cluster  steps merged to one beam. @param skip  turns left
  /// out between two scans
  void start(const Parameters& parameters, int cluster, int skip);
  /// The laser has answered the request of a stream: its clock may have been reset.
  void restart_clock();

  /// Takes a scan, or counts why not.
  /// @param end  when its reply began to leave the laser: arrival less line time
  void add(const Reply& reply, Utime end, Utime arrival);

  const ScanRequest& request() const { return request_; }
  const Parameters& parameters() const { return parameters_; }
  double scan_duration_s() const;
  double scan_period_s() const { return turn_s() * (1 + request_.skip); }

  std::vector<ArrivedScan> take_scans() { return std::exchange(ready_, {}); }
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  const ClockFilter& filter() const { return filter_; }

 private:
  double turn_s() const { return 60.0 / parameters_.rpm; }
  double step_s() const { return turn_s() / parameters_.steps_per_turn; }
  double from_rear_s(int step) const;
  LaserScan scan_of(const Measurement& measured, Utime rear) const;

  Parameters parameters_;
  ScanRequest request_;
  ClockFilter filter_{0.001};
  int64_t device_ms_ = 0;  ///< unwrapped; 0 before the first scan
  uint32_t last_stamp_ms_ = 0;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

struct HokuyoOptions {
  static constexpr const char* kName = "hokuyo";
  static constexpr const char* kDefaultDevice = "/dev/ttyACM0";

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

/// Stops the laser, switches it to SCIP 2.0 and to its speed, asks its parameters and starts the
/// stream. Starts over when the laser falls silent.
class HokuyoDriver final : public Dialogue<ReplyParser, ScanAssembler> {
 public:
  /// @param stream  outlives the driver.
  HokuyoDriver(ByteStream& stream, const HokuyoOptions& options, Clock clock);

  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override { return phase_ != Phase::finding; }
  LaserProperties properties() const override;
  void stop() override { send("QT"); }

  bool measuring() const { return phase_ == Phase::measuring; }

 private:
  enum class Phase { finding, changing_baud, asking_parameters, laser_on, starting, measuring };

  bool asks() const override { return phase_ != Phase::measuring; }
  void on_answer(const Reply& reply, Utime arrival) override;
  void on_timeout() override;
  void enter(Phase phase);
  void ask();
  std::string request_of(Phase phase) const;
  void send(const std::string& line);
  void set_baud(int baud);
  void try_next_baud_rate();
  void start_over(const std::string& why);
  void on_reply(const Reply& reply);
  Duration silence_allowed() const;

  HokuyoOptions options_;
  BaudSearch search_;
  Phase phase_ = Phase::finding;
  int baud_ = 0;  ///< 0 = the line has none
};

}  // namespace marco::drivers::hokuyo
