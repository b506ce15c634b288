#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/cola/codec.hpp"
#include "drivers/laser/dialogue.hpp"
#include "drivers/laser/laser_driver.hpp"
#include "drivers/transport/clock_filter.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::cola {

/// Turns LMDscandata into scans with the time of every beam, by the laser's own microseconds.
class ScanAssembler {
 public:
  /// The laser was asked for a stream: its clock may have been reset.
  void restart_clock();

  /// Takes a scan, or counts why not.
  void add(const ScanData& data, Utime arrival);

  /// Of the last scan, first beam to last [s].
  double scan_duration_s() const { return scan_duration_s_; }
  double scan_period_s() const { return scan_period_s_; }
  /// "" while it is fine.
  const char* trouble() const;

  std::vector<ArrivedScan> take_scans() { return std::exchange(ready_, {}); }
  LaserCounts& counts() { return counts_; }
  const LaserCounts& counts() const { return counts_; }
  const ClockFilter& filter() const { return filter_; }

 private:
  double unwrapped_s(uint32_t sent_us);

  ClockFilter filter_{0.001};
  std::optional<uint32_t> sent_us_;  ///< of the last scan
  double device_s_ = 0.0;            ///< the same without wrapping
  double scan_duration_s_ = 0.05;
  double scan_period_s_ = 1.0 / 15.0;
  uint32_t status_ = 0;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

struct ColaOptions {
  static constexpr const char* kName = "cola";
  static constexpr const char* kDefaultDevice = "tcp:192.168.0.1:2112";

  bool intensities = false;  ///< asks for them, which needs a login; false: as the laser is set
  double range_min_m = 0.05;
  double range_max_m = 0.0;  ///< 0 = the model's
  double range_sigma_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("intensities", intensities);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kNotNegative);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }
};

/// Asks the laser who it is, waits until it is ready, and has it send each scan. What is set for
/// good in the laser stays as it is. Starts over when the laser falls silent.
class ColaDriver final : public Dialogue<TelegramParser, ScanAssembler> {
 public:
  /// @param stream  outlives the driver.
  ColaDriver(ByteStream& stream, const ColaOptions& options, Clock clock);

  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override { return phase_ != Phase::finding; }
  LaserProperties properties() const override;
  void stop() override { send("sEN LMDscandata 0"); }

  const std::string& model() const { return model_; }

 private:
  enum class Phase {
    finding,
    waiting,  ///< until it is ready
    logging_in,
    asking_intensities,
    asking_short_intensities,  ///< of 8 bits: it refused those of 16
    logging_out,
    starting,
    measuring
  };

  bool asks() const override { return phase_ != Phase::measuring; }
  void on_answer(const Telegram& telegram, Utime arrival) override;
  void on_timeout() override;
  static std::string request_of(Phase phase);
  void enter(Phase phase);
  void ask();
  void send(const std::string& text);
  void start_over(const std::string& why);
  void on_scan(const std::string& text, Utime arrival);
  void on_reply(const std::string& text);
  void on_state(const std::string& text);
  Duration silence_allowed() const;

  ColaOptions options_;
  Phase phase_ = Phase::finding;
  std::string model_;
};

}  // namespace marco::drivers::cola
