#include "teleop/head_move.hpp"

#include <algorithm>
#include <cmath>

namespace marco::teleop {
namespace {

constexpr double kStillRad = 0.002;
constexpr double kArrivedS = 0.3;  // stands where it was sent
constexpr double kEndedS = 1.5;    // stands elsewhere: longer than a slow axis needs for a unit
constexpr double kBeginsS = 3.0;   // the board starts a move once it has echoed the order

template <class Angles, class Others>
double apart_rad(const Angles& one, const Others& other) {
  return std::max(std::abs(one.pan_rad - other.pan_rad), std::abs(one.tilt_rad - other.tilt_rad));
}

}  // namespace

HeadMove::Next HeadMove::on_state(const PanTiltState& state) {
  if (!first_) first_ = moved_ = state;
  if (apart_rad(state, moved_) > kStillRad) moved_ = state;
  const double still_s = (state.utime - moved_.utime).seconds();
  if (apart_rad(state, target_) < kNearRad) {
    return still_s >= kArrivedS ? Next::there : Next::wait;
  }
  const bool has_begun = moved_.utime != first_->utime;
  return still_s >= (has_begun ? kEndedS : kBeginsS) ? Next::ended : Next::wait;
}

}  // namespace marco::teleop
