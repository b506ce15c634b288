#pragma once

#include "drivers/base/base_driver.hpp"
#include "drivers/hcs12/base_options.hpp"
#include "drivers/hcs12/line_exchange.hpp"
#include "drivers/hcs12/run_control.hpp"

namespace marco::drivers::hcs12 {

/// Driver of thesis B's base board. Manual and listing differ in forms of reply; either is read as
/// it comes. This class holds the link: what is asked when, replies, timeouts, sonars, batteries.
/// The motion is RunControl's.
class Hcs12Base : public BaseDriver {
 public:
  using Options = Hcs12BaseOptions;
  static constexpr const char* kDevice = "/dev/ttyUSB1";
  static constexpr int kLineSpeed = kBaud;

  explicit Hcs12Base(const Hcs12BaseOptions& options);
  Hcs12Base(const Hcs12Base&) = delete;
  Hcs12Base& operator=(const Hcs12Base&) = delete;

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  /// A line half sent is ended first.
  std::vector<uint8_t> stop_bytes() const override { return {'\n', 'p', '\n'}; }
  BaseDynamics dynamics() const override;
  int64_t bad_input() const override { return exchange_.bad_lines(); }
  int64_t timeouts() const { return timeouts_ + runs_.lost_waits(); }
  int64_t resets() const { return resets_; }
  int64_t left_clicks() const { return runs_.odometry().left_clicks(); }
  int64_t right_clicks() const { return runs_.odometry().right_clicks(); }

 private:
  void start_leg(const Leg& leg, Utime now) override;
  double leg_remaining() const override { return runs_.leg_remaining(); }
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) override;
  void stop_wheels(Utime /*now*/) override { runs_.stop(); }
  BaseVelocity as_driven(const BaseVelocity& order) const override {
    return runs_.as_driven(order, speeds());
  }

  void set_up(Utime now);
  void on_line(const std::string& line, Utime now);
  void on_sonar_line(const std::string& line, Utime now);
  bool on_reply(char letter, const std::string& line, Utime now);
  void on_wheel_status(const WheelStatus& status, Utime measured, Utime now);
  void on_sonar(const std::vector<uint32_t>& times, Utime now);
  void on_timeout(const LineExchange::Request& request, Utime now);
  void on_reset(Utime now);
  void schedule(Utime now);

  Hcs12BaseOptions options_;
  LineExchange exchange_;
  RunControl runs_;
  SonarCollector sonar_;
  Utime next_battery_;
  Utime next_sonar_;
  int64_t timeouts_ = 0;
  int64_t resets_ = 0;
};

}  // namespace marco::drivers::hcs12
