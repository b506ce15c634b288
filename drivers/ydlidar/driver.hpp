#pragma once

#include <optional>
#include <string>

#include "drivers/laser/dialogue.hpp"
#include "drivers/laser/packet_turns.hpp"
#include "drivers/transport/baud_search.hpp"
#include "drivers/ydlidar/answer_parser.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::ydlidar {

struct YdlidarOptions {
  static constexpr const char* kName = "ydlidar";
  static constexpr const char* kDefaultDevice = "/dev/ttyUSB0";

  bool angle_correction = true;  ///< false: Tmini, which looks along its light
  double range_min_m = 0.12;
  double range_max_m = 10.0;
  double range_sigma_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("angle_correction", angle_correction);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kPositive);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }
};

/// Searches the baud rate at which the laser answers, or sends by itself (transmit-only X2);
/// queries its type and health; starts motor and scan. Sample format and rate are detected from the
/// data. Each turn of the head is a scan with irregular bearings.
class YdlidarDriver final : public Dialogue<AnswerParser, PacketTurns> {
 public:
  /// @param stream  outlives the driver.
  YdlidarDriver(ByteStream& stream, const YdlidarOptions& options, Clock clock);

  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override {
    return phase_ > Phase::asking_info && phase_ != Phase::resetting;
  }
  LaserProperties properties() const override;
  void stop() override;

  bool measuring() const { return phase_ == Phase::measuring; }

 private:
  enum class Phase { stopping, asking_info, asking_health, starting, measuring, resetting };

  bool asks() const override { return phase_ != Phase::measuring; }
  void on_answer(const Answer& answer, Utime arrival) override;
  void on_timeout() override;
  void enter(Phase phase);
  void try_next_speed();
  void start_over(const std::string& why);
  void on_health(const Bytes& data);
  void on_packet(const Answer& answer, Utime arrival);
  void send(uint8_t command);

  YdlidarOptions options_;
  BaudSearch search_;
  Phase phase_ = Phase::stopping;
  int unasked_packets_ = 0;  ///< in a row, after a stop was sent
  bool only_talks_ = false;
  std::optional<DeviceInfo> info_;
};

}  // namespace marco::drivers::ydlidar
