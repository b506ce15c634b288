#pragma once

#include <optional>
#include <string>

#include "drivers/laser/packet_turns.hpp"
#include "drivers/transport/baud_search.hpp"
#include "drivers/transport/byte_stream.hpp"
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
class YdlidarDriver final : public LaserDriver {
 public:
  /// @param stream  outlives the driver.
  YdlidarDriver(ByteStream& stream, const YdlidarOptions& options, Clock clock);

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
  enum class Phase { stopping, asking_info, asking_health, starting, measuring, resetting };

  void enter(Phase phase);
  void try_next_speed();
  void start_over(const std::string& why);
  void on_timeout();
  void on_answer(const Answer& answer, Utime arrival);
  void on_health(const Bytes& data);
  void on_packet(const Answer& answer, Utime arrival);
  void send(uint8_t command);

  ByteStream& stream_;
  YdlidarOptions options_;
  Clock clock_;
  BaudSearch search_;
  AnswerParser parser_;
  PacketTurns turns_;
  Phase phase_ = Phase::stopping;
  int tries_ = 0;
  Utime deadline_;           ///< of the phase; while measuring, of the next packet
  int unasked_packets_ = 0;  ///< in a row, after a stop was sent
  bool only_talks_ = false;
  std::optional<DeviceInfo> info_;
  std::string trouble_;
};

}  // namespace marco::drivers::ydlidar
