#pragma once

#include <string>

#include "drivers/laser/dialogue.hpp"
#include "drivers/rplidar/turn_assembler.hpp"
#include "drivers/transport/baud_search.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::rplidar {

struct RplidarOptions {
  static constexpr const char* kName = "rplidar";
  static constexpr const char* kDefaultDevice = "/dev/ttyUSB0";

  int baud = 0;                  ///< 0 = searched: 115200, 256000, 460800 and 1000000 are tried
  std::string mode = "express";  ///< or "standard": half the samples
  int motor_pwm = 660;           ///< of an A2's accessory board
  double range_min_m = 0.15;
  double range_max_m = 0.0;  ///< 0 = what the laser says of itself, or 12
  double range_sigma_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{0, 1'000'000});
    v("mode", mode);
    v("motor_pwm", motor_pwm, Limits{0, 1023});
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kNotNegative);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }
};

/// Starts motor and scan. Each turn of the head is a scan with irregular bearings.
class RplidarDriver final : public Dialogue<AnswerParser, TurnAssembler> {
 public:
  /// @param stream  outlives the driver. @throws std::invalid_argument for an unknown mode or baud.
  RplidarDriver(ByteStream& stream, const RplidarOptions& options, Clock clock);

  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override {
    return phase_ > Phase::asking_info && phase_ != Phase::resetting;
  }
  LaserProperties properties() const override;
  void stop() override;

  bool measuring() const { return phase_ == Phase::measuring; }

 private:
  enum class Phase {
    stopping,
    asking_info,
    asking_health,
    asking_rate,  ///< A1, A2
    asking_mode,  ///< A3, C1, S: which one is usual, then its properties
    asking_answer,
    asking_period,
    asking_range,
    starting,
    measuring,
    resetting
  };
  /// What its INFO said, and its configuration.
  struct Laser {
    int model = 0;     ///< 0 = not known yet
    int firmware = 0;  ///< 256 a major version
    int mode = 0;      ///< of an express scan
    double range_max_m = 12.0;
  };
  struct SamplePeriods {
    double standard_s = 508e-6;
    double express_s = 254e-6;
  };

  bool asks() const override { return phase_ != Phase::measuring; }
  bool is_receiving() const override {
    return phase_ != Phase::stopping && phase_ != Phase::resetting;
  }
  void on_answer(const Block& block, Utime arrival) override;
  void on_timeout() override;
  void try_next_speed();
  void enter(Phase phase);
  bool tells_modes() const;
  void ask_configuration(Phase phase);
  void on_configuration(const Block& block);
  void start_scan();
  void start_over(const std::string& why);
  void on_reply(const Block& block);

  RplidarOptions options_;
  BaudSearch search_;
  Phase phase_ = Phase::stopping;
  bool express_;
  Laser laser_;
  SamplePeriods periods_;
};

}  // namespace marco::drivers::rplidar
