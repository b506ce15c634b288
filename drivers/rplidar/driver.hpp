#pragma once

#include <string>

#include "drivers/rplidar/turn_assembler.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::rplidar {

struct RplidarOptions {
  static constexpr const char* kName = "rplidar";
  static constexpr const char* kDefaultDevice = "/dev/ttyUSB0";

  int baud = 115'200;            ///< 256000 for A2M12 and A3
  std::string mode = "express";  ///< or "standard": half the samples
  int motor_pwm = 660;           ///< of an A2's accessory board
  double range_min_m = 0.15;
  double range_max_m = 12.0;
  double range_sigma_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{9600, 1'000'000});
    v("mode", mode);
    v("motor_pwm", motor_pwm, Limits{0, 1023});
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kPositive);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }
};

/// Starts motor and scan. Each turn of the head is a scan with irregular bearings.
class RplidarDriver final : public LaserDriver {
 public:
  /// @param stream  outlives the driver. @throws std::invalid_argument for an unknown mode or baud.
  RplidarDriver(ByteStream& stream, const RplidarOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override {
    return phase_ > Phase::asking_info && phase_ != Phase::resetting;
  }
  LaserProperties properties() const override;
  const LaserCounts& counts() const override { return turns_.counts(); }
  void stop() override;

  bool measuring() const { return phase_ == Phase::measuring; }

 private:
  enum class Phase {
    stopping,
    asking_info,
    asking_health,
    asking_rate,
    starting,
    measuring,
    resetting
  };
  struct SamplePeriods {
    double standard_s = 508e-6;
    double express_s = 254e-6;
  };

  void enter(Phase phase);
  void start_scan();
  void start_over(const std::string& why);
  void on_timeout();
  void on_block(const Block& block, Utime arrival);
  void on_answer(const Block& block);

  ByteStream& stream_;
  RplidarOptions options_;
  Clock clock_;
  AnswerParser parser_;
  TurnAssembler turns_;
  Phase phase_ = Phase::stopping;
  bool express_;
  int tries_ = 0;
  Utime deadline_;  ///< of the phase; while measuring, of the next samples
  int model_ = 0;
  SamplePeriods periods_;
  std::string trouble_;
};

}  // namespace marco::drivers::rplidar
