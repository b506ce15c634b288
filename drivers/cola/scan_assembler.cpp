#include "drivers/cola/scan_assembler.hpp"

#include <algorithm>
#include <cmath>

#include "common/pose2.hpp"

namespace marco::drivers::cola {
namespace {

constexpr uint16_t kLeastRange = 16;  // below: no echo, or a code
constexpr double kDegPerE4 = 1e-4;

/// Whether the angles of a channel lie within a turn and its beams have some order in time.
bool is_measurable(const Channel& ranges, uint32_t rate_chz) {
  const double span_deg =
      kDegPerE4 * std::abs(ranges.step_e4) * static_cast<double>(ranges.values.size());
  return ranges.values.size() > 1 && ranges.step_e4 != 0 && span_deg <= 361.0 && rate_chz > 0 &&
         ranges.scale > 0.0;
}

}  // namespace

void ScanAssembler::restart_clock() {
  filter_.reset();
  sent_us_.reset();
  device_s_ = 0.0;
}

const char* ScanAssembler::trouble() const {
  if ((status_ & 1U) != 0 && (status_ & 4U) == 0) return "the laser reports an error";
  return status_ != 0 ? "the laser's window is dirty: wipe it" : "";
}

double ScanAssembler::unwrapped_s(uint32_t sent_us) {
  device_s_ += 1e-6 * static_cast<double>(sent_us - sent_us_.value_or(sent_us));
  sent_us_ = sent_us;
  return device_s_;
}

void ScanAssembler::add(const ScanData& data, Utime arrival) {
  const Channel* ranges = data.channel("DIST1");
  if (ranges == nullptr || !is_measurable(*ranges, data.rate_chz)) {
    ++counts_.drops["inconsistent"];
    return;
  }
  ++counts_.scans;
  status_ = data.status;
  scan_period_s_ = 100.0 / data.rate_chz;
  const double beam_s = scan_period_s_ * kDegPerE4 * std::abs(ranges->step_e4) / 360.0;
  scan_duration_s_ = beam_s * static_cast<double>(ranges->values.size() - 1);
  const Utime sent = filter_.update(unwrapped_s(data.sent_us), arrival);
  // No scan is sent before its last beam was measured, whatever the stamps say.
  const double since_begin_s = 1e-6 * static_cast<double>(data.sent_us - data.begin_us);
  const bool likely = since_begin_s < scan_duration_s_ + 10.0 * scan_period_s_;

  ArrivedScan arrived;
  arrived.arrival = arrival;
  LaserScan& scan = arrived.scan;
  scan.utime = sent - Duration::from_seconds(likely ? std::max(since_begin_s, scan_duration_s_)
                                                    : scan_duration_s_);
  scan.first_bearing_rad = deg_to_rad(kDegPerE4 * ranges->start_e4 - kAheadDeg);
  scan.bearing_step_rad = deg_to_rad(kDegPerE4 * ranges->step_e4);
  for (std::size_t i = 0; i < ranges->values.size(); ++i) {
    const bool echo = ranges->values[i] >= kLeastRange;
    scan.ranges_m.push_back(echo ? static_cast<float>(1e-3 * ranges->scaled(i)) : 0.0F);
    scan.time_offsets_s.push_back(static_cast<float>(beam_s * static_cast<double>(i)));
  }
  const Channel* intensities = data.channel("RSSI1");
  for (std::size_t i = 0; intensities != nullptr && i < intensities->values.size(); ++i) {
    arrived.intensities.push_back(static_cast<float>(intensities->scaled(i)));
  }
  ready_.push_back(std::move(arrived));
}

}  // namespace marco::drivers::cola
