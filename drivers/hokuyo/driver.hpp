#pragma once

#include <string>

#include "drivers/hokuyo/scan_assembler.hpp"
#include "drivers/laser/dialogue.hpp"
#include "drivers/transport/baud_search.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::hokuyo {

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
