#pragma once

#include <optional>
#include <string>
#include <utility>

#include "drivers/base/differential_base.hpp"
#include "drivers/base/wheel_counters.hpp"
#include "drivers/create/codec.hpp"
#include "drivers/transport/baud_search.hpp"

namespace marco::drivers::create {

struct CreateOptions {
  /// 0 = searched: 115200, 19200 (after three pulses of its BRC line), 57600 (Roombas before the
  /// 500)
  int baud = 0;
  double wheel_diameter_m = kWheelDiameterM;
  double track_m = kTrackM;
  BaseSpeeds speeds{0.25, 1.0, 0.3};
  /// Its emulator stops within 0.17 s and the plan's braking; a slower host adds to that.
  GuardOptions guard{.body_m = Footprint::box(0.17, 0.17, 0.17), .delay_s = 0.25};

  template <class Visitor>
  void visit(Visitor& v) {
    v("baud", baud, Limits{0, 115'200});
    v("wheel_diameter_m", wheel_diameter_m, kPositive);
    v("track_m", track_m, kPositive);
    v("speeds", speeds);
    v("guard", guard);
  }
};

/// Driver of a Create 2 or Roomba in its mode "safe", in which the robot itself stops at a cliff or
/// a hanging wheel. The robot has no watchdog: when this process hangs or dies its guardian stops
/// it; when the cable falls out it drives on until something stops it.
class CreateBase : public DifferentialBase {
 public:
  using Options = CreateOptions;
  static constexpr const char* kDevice = "/dev/ttyUSB0";
  static constexpr int kLineSpeed = kBaud;  ///< at first: others are searched

  explicit CreateBase(const CreateOptions& options);

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  std::vector<uint8_t> stop_bytes() const override;
  void shut_down(std::vector<uint8_t>& out) override;
  std::optional<int> take_line_speed() override { return std::exchange(speed_due_, std::nullopt); }
  int64_t bad_input() const override { return parser_.garbage_bytes() + counters_.implausible(); }

 private:
  void keep_link(Utime now, std::vector<uint8_t>& out) override;
  bool takes_speeds() const override { return streams_; }
  void send_speeds(const WheelSpeeds& speeds, bool due, std::vector<uint8_t>& out) override;

  void start_session(Utime now);
  void on_sensors(const Sensors& sensors, Utime left);
  void count(const Sensors& sensors, Utime left);
  void judge(const Sensors& sensors, Utime now);
  static std::string why_unsafe(const Sensors& sensors);
  void ask(Utime now, std::vector<uint8_t>& out);

  FrameParser parser_;
  BaudSearch search_;
  std::optional<int> speed_due_;
  bool heard_ = false;  ///< a frame at this speed, ever
  Utime next_speed_;    ///< when the next one is tried
  WheelCounters counters_;
  bool streams_ = false;            ///< its frames come
  bool safe_due_ = true;            ///< its mode "safe" is to be asked for
  bool may_be_safe_ = true;         ///< nothing is in the way of it
  Utime asked_since_;               ///< for so long in vain
  std::optional<Utime> last_left_;  ///< when the last frame left the robot
};

}  // namespace marco::drivers::create
