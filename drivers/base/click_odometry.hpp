#pragma once

#include "common/samples.hpp"

namespace marco::drivers {

/// Dead reckoning from the clicks of the two wheels. Stamps never go back: a counted pose is as old
/// as its line, and predictions may have been published since.
class ClickOdometry {
 public:
  /// What the wheels did since the last count; signed, ahead > 0.
  struct Step {
    double left_clicks = 0.0;
    double right_clicks = 0.0;
    double left_m_per_s = 0.0;
    double right_m_per_s = 0.0;
  };

  ClickOdometry(double metres_per_click, double track_m)
      : metres_per_click_(metres_per_click), track_m_(track_m) {}

  /// The pose after a step reported by the counters; the next one begins there.
  OdometrySample count(const Step& step, Utime measured);
  /// The pose after a step that is only expected.
  OdometrySample predict(const Step& step, Utime now);
  /// The host's clock may have been set back.
  void forget_stamps() { last_stamp_ = {}; }

  int64_t left_clicks() const { return left_clicks_; }
  int64_t right_clicks() const { return right_clicks_; }

 private:
  double metres_per_click_;
  double track_m_;
  Pose2 odom_from_robot_;  ///< by the counters alone
  int64_t left_clicks_ = 0;
  int64_t right_clicks_ = 0;
  Utime last_stamp_;
};

}  // namespace marco::drivers
