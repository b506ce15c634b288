#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "drivers/p2os/visca.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers::p2os {

/// `value` one step nearer to `goal`, not beyond it.
inline double approach(double value, double goal, double step) {
  return value < goal ? std::min(goal, value + step) : std::max(goal, value - step);
}

/// A camera on a pan-tilt of its own at the robot's second serial port, of the kind most Pioneers
/// carried: a Sony EVI-D30, which speaks VISCA (8x command ... FF, answers 9x ... FF). Thesis A
/// does not name its own; this choice is ours. Pan +-95 deg (left positive here), tilt +-20 deg.
class CameraHead {
 public:
  /// Bytes from the robot's port.
  void receive(std::span<const uint8_t> bytes, Utime now);
  void advance(Utime now);
  /// What it answered and nobody has fetched yet.
  std::vector<uint8_t>& answers() { return answers_; }

  double pan_rad() const;
  double tilt_rad() const;
  bool moving() const { return pan_ != pan_goal_ || tilt_ != tilt_goal_; }
  int zoom() const { return zoom_; }
  bool on() const { return on_; }

 private:
  void handle(std::span<const uint8_t> message);
  void pan_tilt(std::span<const uint8_t> message);
  void done();
  void say(std::initializer_list<int> bytes);
  void say_words(std::initializer_list<int> words);

  std::vector<uint8_t> message_;
  std::vector<uint8_t> answers_;
  Utime now_;
  double pan_ = 0.0, tilt_ = 0.0;  ///< device units, right and up positive
  double pan_goal_ = 0.0, tilt_goal_ = 0.0;
  double pan_rate_ = 0.0, tilt_rate_ = 0.0;  ///< units a second
  int zoom_ = 0;
  bool on_ = true;
  bool tell_arrival_ = false;
};

}  // namespace marco::drivers::p2os
