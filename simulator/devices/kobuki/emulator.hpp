#pragma once

#include <functional>

#include "drivers/kobuki/codec.hpp"
#include "drivers/transport/paced_output.hpp"
#include "simulator/devices/lagging_wheel.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::kobuki {

struct KobukiEmulatorOptions {
  double lag_s = 0.03;  ///< time constant of its wheels
  double boot_s = 1.0;  ///< from a reset until it speaks
  int decivolts = 165;  ///< of its battery
  double gyro_bias_deg_per_s = 0.0;
};

/// What touches the robot.
struct KobukiWorld {
  uint8_t bumpers = 0, cliffs = 0, hanging_wheels = 0, charger = 0;  ///< bits as in Feedback
};

/// A Kobuki as its line shows it: frames every 20 ms, unasked, with its clock, counters that wrap,
/// and its gyro. It holds the last speed without end, and drives over a cliff when told to.
class KobukiEmulator final : public Emulator {
 public:
  explicit KobukiEmulator(const KobukiEmulatorOptions& options = {},
                          std::function<KobukiWorld()> world = {});

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  /// It was switched off and on: it stands, its clock and counters begin at 0.
  void reset(Utime now);
  double left_m() const { return left_.travelled_m; }  ///< signed, since it was made
  double right_m() const { return right_.travelled_m; }
  double left_m_per_s() const { return left_.speed_m_per_s; }
  double right_m_per_s() const { return right_.speed_m_per_s; }

 private:
  void run_until(Utime now);
  void obey(const Order& order);
  Feedback feedback();

  KobukiEmulatorOptions options_;
  std::function<KobukiWorld()> world_;
  FrameParser parser_;
  PacedOutput output_;
  bool started_ = false;  ///< its time runs
  bool tells_versions_ = false;
  Utime born_, ready_, now_, next_frame_;
  double heading_rad_ = 0.0;
  LaggingWheel left_, right_;
};

}  // namespace marco::drivers::kobuki
