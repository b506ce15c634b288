#include "drivers/base/click_odometry.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/base/arc.hpp"

namespace marco::drivers {

OdometrySample ClickOdometry::count(const Step& step, Utime measured) {
  const OdometrySample sample = predict(step, measured);
  odom_from_robot_ = sample.odom_from_robot;
  left_clicks_ = sample.left_clicks;
  right_clicks_ = sample.right_clicks;
  return sample;
}

OdometrySample ClickOdometry::predict(const Step& step, Utime now) {
  last_stamp_ = std::max(now, last_stamp_ + Duration::from_us(1));
  const double left_m = step.left_clicks * metres_per_click_;
  const double right_m = step.right_clicks * metres_per_click_;
  OdometrySample sample;
  sample.utime = last_stamp_;
  sample.odom_from_robot =
      odom_from_robot_ * along_arc((left_m + right_m) / 2.0, (right_m - left_m) / track_m_);
  sample.velocity_m_per_s = (step.left_m_per_s + step.right_m_per_s) / 2.0;
  sample.yaw_rate_rad_per_s = (step.right_m_per_s - step.left_m_per_s) / track_m_;
  sample.left_clicks = left_clicks_ + static_cast<int64_t>(step.left_clicks);
  sample.right_clicks = right_clicks_ + static_cast<int64_t>(step.right_clicks);
  return sample;
}

}  // namespace marco::drivers
