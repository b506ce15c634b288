#pragma once

#include <optional>
#include <string>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/rplidar/codec.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "drivers/transport/clock_filter.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::rplidar {

struct RplidarOptions {
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

/// Starts motor and scan and gathers the samples of each turn into one scan of irregular bearings
/// and times (LIDAR_RAW). The samples, equally far apart in time, are the clock: their count
/// against the arrivals gives each its time. An express capsule whose successor was lost has no
/// angles and is dropped.
class RplidarDriver final : public LaserDriver {
 public:
  /// @param stream  outlives the driver. @throws std::invalid_argument for a mode it does not know.
  RplidarDriver(ByteStream& stream, const RplidarOptions& options, Clock clock);

  std::vector<ArrivedScan> step() override;
  void on_line_emptied() override;
  std::string state() const override;
  bool answers() const override {
    return phase_ > Phase::asking_info && phase_ != Phase::resetting;
  }
  LaserSight sight() const override;
  const LaserCounts& counts() const override { return counts_; }
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

  void enter(Phase phase);
  void start_over(const std::string& why);
  void on_timeout();
  void on_block(const Block& block, Utime arrival);
  void on_answer(const Block& block);
  void on_node(const Block& block, Utime arrival);
  void on_capsule(const Block& block, Utime arrival);
  bool spans_one(const Capsule& next);
  void note_arrival(Utime arrival);
  void lose_count();
  void add_sample(double angle_deg, double range_m, bool new_turn);
  void finish_turn();
  double sample_s() const { return express_ ? express_s_ : standard_s_; }

  ByteStream& stream_;
  RplidarOptions options_;
  Clock clock_;
  AnswerParser parser_;
  Phase phase_ = Phase::stopping;
  bool express_ = true;
  int tries_ = 0;
  Utime deadline_;
  Utime last_block_;
  int model_ = 0;
  double standard_s_ = 508e-6;
  double express_s_ = 254e-6;
  std::string trouble_;

  ClockFilter filter_{0.02};
  int64_t sample_ = 0;       ///< number of the next
  double noted_s_ = 0.0;     ///< device time of the last arrival given to the filter
  Utime last_sample_utime_;  ///< of the sample noted last
  int64_t last_noted_sample_ = 0;
  Utime last_arrival_;
  std::optional<Capsule> capsule_;  ///< waits for its successor
  double usual_span_deg_ = 0.0;
  double last_angle_deg_ = 0.0;
  std::optional<LaserScan> turn_;  ///< being gathered; none before the first turn's beginning
  std::vector<int64_t> turn_samples_;
  double turn_s_ = 0.18;
  LaserCounts counts_;
  std::vector<ArrivedScan> ready_;
};

}  // namespace marco::drivers::rplidar
