#pragma once

#include <optional>

#include "drivers/base/base_driver.hpp"
#include "drivers/hcs12/codec.hpp"
#include "drivers/hcs12/line_exchange.hpp"
#include "drivers/hcs12/ramp.hpp"

namespace marco::drivers::hcs12 {

/// Geometry that the thesis leaves open is ours: wheels of 30 cm, 50 cm apart.
struct Hcs12BaseOptions {
  double clicks_per_wheel_turn = 65500.0;  ///< 1000 clicks, gear 65.5:1
  double wheel_diameter_m = 0.30;          ///< ours
  double track_m = 0.50;                   ///< ours
  /// Clicks a tick up to which the counters may be read in motion: printing `l` takes 26 ticks, in
  /// which an eight-bit counter must not overflow. Faster moves are read at their end.
  double poll_limit_clicks = 9.0;
  double poll_period_s = 0.1;
  double velocity_limit_m_per_s = 0.13;  ///< in velocity mode, which must be read in motion
  bool sonar = true;
  double sonar_ring_radius_m = 0.25;  ///< ours
  double sonar_cone_deg = 15.0;
  double speed_of_sound_m_per_s = 343.0;
  BaseSpeeds speeds;
  GuardOptions guard;

  template <class Visitor>
  void visit(Visitor& v) {
    v("clicks_per_wheel_turn", clicks_per_wheel_turn, kPositive);
    v("wheel_diameter_m", wheel_diameter_m, kPositive);
    v("track_m", track_m, kPositive);
    v("poll_limit_clicks", poll_limit_clicks, Limits{1.0, 90.0});
    v("poll_period_s", poll_period_s, Limits{0.05, 10.0});
    v("velocity_limit_m_per_s", velocity_limit_m_per_s, kPositive);
    v("sonar", sonar);
    v("sonar_ring_radius_m", sonar_ring_radius_m, kNotNegative);
    v("sonar_cone_deg", sonar_cone_deg, kPositive);
    v("speed_of_sound_m_per_s", speed_of_sound_m_per_s, kPositive);
    v("speeds", speeds);
    v("guard", guard);
  }
};

/// Driver of thesis B's base board. Manual and listing differ in forms of reply; either is read as
/// it comes. Odometry counts clicks with the sign of the order, for the counters have none. A fast
/// move is followed by the firmware's own ramp and settled by the counters at its end. The board
/// drives straight or turns on the spot: of a velocity the larger part is driven.
///
/// The board knows no deadline and no watchdog: once told, it drives to the end of its run. So no
/// run is long. A velocity is a run of kVelocityRunS, renewed while it is driven; a longer leg is
/// driven in pieces of kLegRunS. That long the wheels turn at most after this process, or the line,
/// has died.
class Hcs12Base : public BaseDriver {
 public:
  static constexpr double kVelocityRunS = 1.0;
  static constexpr double kLegRunS = 5.0;

  explicit Hcs12Base(const Hcs12BaseOptions& options);

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  void shut_down(std::vector<uint8_t>& out) override;
  int64_t bad_input() const override { return bad_lines_ + exchange_.overlong(); }
  int64_t timeouts() const { return timeouts_; }
  int64_t resets() const { return resets_; }
  int64_t left_clicks() const { return left_sum_; }
  int64_t right_clicks() const { return right_sum_; }

 private:
  static constexpr uint32_t kMaxClicksPerTick = 90;  ///< what a wheel can do
  static constexpr double kStuckS = 0.5;             ///< without a click: it does not move

  /// One a, r, i or d from its sending to the counters' last word.
  struct Run {
    char letter = 'a';
    int left_sign = 1;
    int right_sign = 1;
    uint32_t tenths = 0;
    uint32_t tenths_behind = 0;  ///< of the leg, for runs that follow this one
    Ramp ramp;
    bool polled = true;        ///< slow enough for its counters to be read in motion
    bool of_velocity = false;  ///< its end is no leg's end
    bool started = false;
    RampWalk walk;  ///< where it should be by now
    Utime started_at;
    Utime rested_at;         ///< by the answer of `w`
    uint32_t left_read = 0;  ///< counters at the last reading
    uint32_t right_read = 0;
    Utime read_at;
    double left_clicks_per_s = 0.0, right_clicks_per_s = 0.0;  ///< between the last two
    Utime progress_at;                                         ///< when they last grew
    int retries = 0;
    bool stood_still = false;  ///< this process did: what it read then was said earlier
  };

  void start_leg(const Leg& leg, Utime now) override;
  double leg_remaining() const override;
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) override;
  void stop_wheels(Utime now) override;
  void speeds_changed() override {}
  double stop_distance_m() const override;

  void set_up(Utime now);
  void start_run(Run run, Utime now);
  static void prepare(Run& run, double poll_limit_clicks, Utime now);
  void ask_ramp(const Ramp& ramp);
  void renew(Run next, Utime now);
  void take_over(Utime started);
  void start_piece(const Run& last, Utime now);
  static bool differs(const Run& wanted, const Run& driven);
  void on_line(const std::string& line, Utime now);
  bool on_reply(char letter, const std::string& line, Utime now);
  void on_wheel_status(const WheelStatus& status, Utime measured, Utime now);
  void on_run_over(Utime now);
  void take_up_lost_run(Utime now);
  void on_sonar(const std::vector<uint32_t>& times, Utime now);
  void on_timeout(const LineExchange::Request& request, Utime now);
  void on_reset(Utime now);
  void schedule(Utime now);
  void follow_ramp(Utime now);
  void ask_status(bool first = false);
  void ask_stop();
  void ask_wait(Utime now);
  Utime later_stamp(Utime stamp);
  void learn_pace(const Run& run);
  void note_time(Utime now);
  void publish(Utime measured, double ahead_left, double ahead_right, double v, double w);
  double metres_per_click() const;
  uint32_t clicks_per_tick(double wheel_m_per_s) const;
  Ramp ramp_for(double wheel_m_per_s, double wheel_m_per_s2) const;

  Hcs12BaseOptions options_;
  LineExchange exchange_;
  SonarCollector sonar_;
  std::optional<Run> run_;
  std::optional<Run> renewal_;       ///< asked for: follows on run_ when the board has it
  std::optional<Ramp> board_ramp_;   ///< as last told to it
  bool renewal_unanswered_ = false;  ///< whether the board has it the counters tell
  std::optional<Run> lost_run_;      ///< when the line went; the board counts on
  bool connected_ = false;
  bool stop_asked_ = false;  ///< stop_wheels waits for the counters
  double pace_ = 1.0;  ///< how fast the board really works off its ramp, learnt from fast moves
  bool wait_armed_ = false;  ///< a `w` will answer when the wheels rest
  Utime wait_until_;         ///< or has been lost
  Pose2 counted_pose_;       ///< odometry by the counters alone
  int64_t left_sum_ = 0;
  int64_t right_sum_ = 0;
  Utime last_stamp_, last_step_;
  Utime next_status_, next_battery_, next_sonar_, next_ping_, next_prediction_;
  int silent_ = 0;  ///< timeouts in a row
  int implausible_ = 0;
  int64_t bad_lines_ = 0;
  int64_t timeouts_ = 0;
  int64_t resets_ = 0;
};

}  // namespace marco::drivers::hcs12
