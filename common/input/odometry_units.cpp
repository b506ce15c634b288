#include "common/input/odometry_units.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/input/input_gates.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco {
namespace {

using namespace input_gates;

// Wrong units are in every step: 20 are a second or two, and older ones than 200 count half.
constexpr int kLeastTooFast = 20, kMostSteps = 200;
constexpr double kWayM = 0.05, kTurnRad = 0.05;  // below that it is noise of the wheels

}  // namespace

void OdometryUnits::Steps::note(double moved, double seconds, double counts_from, double limit) {
  if (moved < counts_from) return;
  ++moving;
  if (moved > limit * seconds) {
    ++too_fast;
    fastest = std::max(fastest, moved / seconds);
  }
  if (moving < kMostSteps) return;
  moving /= 2;
  too_fast /= 2;
}

bool OdometryUnits::Steps::are_wrong() const {
  return too_fast >= kLeastTooFast && too_fast >= kTooFastPart * moving;
}

std::optional<std::string> OdometryUnits::look(const OdometrySample& sample) {
  if (verdict_) return verdict_;
  const auto last = std::exchange(last_, sample);
  if (!last) return std::nullopt;
  const double dt_s = (sample.utime - last->utime).seconds();
  if (dt_s <= 0.0) return std::nullopt;
  ++steps_;
  seconds_ += dt_s;
  // Stamped on arrival some come in bursts.
  const double step_s = std::max(dt_s, seconds_ / steps_);
  const Pose2 moved = between(last->odom_from_robot, sample.odom_from_robot);
  ways_.note(moved.translation_m().norm(), step_s, kWayM, kFastestRobotMPerS);
  turns_.note(std::abs(moved.theta_rad), step_s, kTurnRad, kFastestTurnRadPerS);
  if (ways_.are_wrong()) {
    verdict_ = format(
        "odometry drives at %.0f m/s, faster than any robot in a building: are these "
        "millimetres? Marco takes metres; this odometry is not used",
        ways_.fastest);
  } else if (turns_.are_wrong()) {
    verdict_ = format(
        "odometry turns at %.0f rad/s, faster than any robot: is its heading in degrees? "
        "Marco takes radians; this odometry is not used",
        turns_.fastest);
  }
  return verdict_;
}

}  // namespace marco
