#include "drivers/hokuyo/scan_assembler.hpp"

#include <numbers>

namespace marco::drivers::hokuyo {
namespace {

constexpr uint32_t kStampMask = 0xFFFFFF;

}  // namespace

void ScanAssembler::start(const Parameters& parameters, int cluster, int skip) {
  parameters_ = parameters;
  request_ = {true, 3, parameters.first_step, parameters.last_step, cluster, skip, 0};
}

void ScanAssembler::restart_clock() {
  filter_.reset();
  device_ms_ = 0;
}

double ScanAssembler::scan_duration_s() const {
  return step_s() * (parameters_.last_step - parameters_.first_step);
}

double ScanAssembler::from_rear_s(int step) const {
  const int rear_step = parameters_.front_step - parameters_.steps_per_turn / 2;
  return step_s() * (step - rear_step);
}

void ScanAssembler::add(const Reply& reply, Utime end, Utime arrival) {
  const auto measured = decode_measurement(reply, request_);
  if (!measured) {
    ++counts_.drops["inconsistent"];
    return;
  }
  ++counts_.scans;
  device_ms_ += device_ms_ == 0 ? 1 : (measured->timestamp_ms - last_stamp_ms_) & kStampMask;
  last_stamp_ms_ = measured->timestamp_ms;
  // The stamp is of the rear, before the first beam; the reply leaves after the last one.
  const Utime rear = end - Duration::from_seconds(from_rear_s(request_.last_step));
  const Utime filtered = filter_.update(static_cast<double>(device_ms_) * 1e-3, rear);
  ready_.push_back({scan_of(*measured, filtered), arrival});
}

LaserScan ScanAssembler::scan_of(const Measurement& measured, Utime rear) const {
  LaserScan scan;
  const double step_rad = 2.0 * std::numbers::pi / parameters_.steps_per_turn;
  // A merged beam stands for the middle of its steps.
  const double middle = 0.5 * (request_.cluster - 1);
  scan.utime = rear + Duration::from_seconds(from_rear_s(request_.first_step) + middle * step_s());
  scan.first_bearing_rad = (request_.first_step - parameters_.front_step + middle) * step_rad;
  scan.bearing_step_rad = step_rad * request_.cluster;
  const auto beyond_m = static_cast<float>(0.001 * parameters_.range_max_mm);
  const double beam_s = step_s() * request_.cluster;
  for (const uint32_t value_mm : measured.values_mm) {
    const bool code = value_mm < static_cast<uint32_t>(parameters_.range_min_mm);
    const bool beyond = value_mm > static_cast<uint32_t>(parameters_.range_max_mm);
    scan.time_offsets_s.push_back(static_cast<float>(beam_s * static_cast<double>(scan.size())));
    scan.ranges_m.push_back(code ? 0.0f : beyond ? beyond_m : static_cast<float>(value_mm * 0.001));
  }
  return scan;
}

}  // namespace marco::drivers::hokuyo
