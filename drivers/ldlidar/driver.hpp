#pragma once

#include <optional>
#include <string>

#include "drivers/laser/dialogue.hpp"
#include "drivers/laser/packet_turns.hpp"
#include "drivers/ldlidar/codec.hpp"
#include "drivers/transport/baud_search.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::ldlidar {

struct LdlidarOptions {
  static constexpr const char* kName = "ldlidar";
  static constexpr const char* kDefaultDevice = "/dev/ttyUSB0";

  bool clockwise = true;  ///< false: a laser whose pictures come out mirrored
  double range_min_m = 0.02;
  double range_max_m = 0.0;  ///< 0 = the model's: 12 m, or 25 m of an STL27L
  double range_sigma_m = 0.01;

  template <class Visitor>
  void visit(Visitor& v) {
    v("clockwise", clockwise);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kNotNegative);
    v("range_sigma_m", range_sigma_m, kNotNegative);
  }
};

/// Listens at each speed in turn until packets come. Which model it is and how fast it measures is
/// known from what arrives. Each turn of the head is a scan with irregular bearings.
class LdlidarDriver final : public Dialogue<PacketParser, PacketTurns> {
 public:
  /// @param stream  outlives the driver.
  LdlidarDriver(ByteStream& stream, const LdlidarOptions& options, Clock clock);

  void on_input_flushed() override;
  std::string state() const override;
  bool answers() const override { return heard_; }
  LaserProperties properties() const override;

 private:
  bool asks() const override { return false; }
  void on_answer(const Received& received, Utime arrival) override;
  void on_timeout() override;
  void listen_at_next_speed();
  double unwrapped_s(int stamp_ms);

  LdlidarOptions options_;
  BaudSearch search_;
  bool heard_ = false;           ///< its packets come
  std::optional<int> stamp_ms_;  ///< of the last packet
  double stamps_s_ = 0.0;        ///< the same without wrapping
};

}  // namespace marco::drivers::ldlidar
