#include "simulator/live/live_pantilt.hpp"

namespace marco::sim {
namespace {

constexpr double kWrongTiltDeg = 2.0;  // of the fault `wrong`

double angle_rad(const drivers::hcs12::PanTiltAxisOptions& axis, double units) {
  return deg_to_rad(axis.home_deg + units * axis.deg_per_unit);
}

}  // namespace

drivers::hcs12::PanTiltEmulatorOptions LivePanTilt::board_options(const LivePanTiltSpec& spec) {
  drivers::hcs12::PanTiltEmulatorOptions options;
  options.listing_status = options.listing_stop = !spec.manual_firmware;
  options.pan_limit_units = spec.pan.limit_units;
  options.tilt_limit_units = spec.tilt.limit_units;
  return options;
}

void LivePanTilt::look(MotionHistory::Moment& moment) {
  if (!faults_.has("pantilt", FaultKind::stuck, moment.when)) {
    last_pan_rad_ = angle_rad(spec_.pan, board_.pan_units());
    last_tilt_rad_ = angle_rad(spec_.tilt, board_.tilt_units());
    if (faults_.has("pantilt", FaultKind::wrong, moment.when)) {
      last_tilt_rad_ += deg_to_rad(kWrongTiltDeg);
    }
  }
  moment.pan_rad = last_pan_rad_;
  moment.tilt_rad = last_tilt_rad_;
}

}  // namespace marco::sim
